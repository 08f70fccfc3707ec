//! `satseed info`

use super::Exit;
use super::args::InfoArgs;

pub(crate) fn run(_args: &InfoArgs) -> anyhow::Result<Exit> {
    anyhow::bail!("info is not built yet")
}
