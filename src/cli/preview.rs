//! `satseed preview`

use super::Exit;
use super::args::PreviewArgs;

pub(crate) fn run(_args: &PreviewArgs) -> anyhow::Result<Exit> {
    anyhow::bail!("preview is not built yet")
}
