//! `satseed generate`

use super::Exit;
use super::args::GenerateArgs;

pub(crate) fn run(_args: &GenerateArgs) -> anyhow::Result<Exit> {
    anyhow::bail!("generate is not built yet")
}
