//! `satseed explain`

use super::Exit;
use super::args::ExplainArgs;

pub(crate) fn run(_args: &ExplainArgs) -> anyhow::Result<Exit> {
    anyhow::bail!("explain is not built yet")
}
