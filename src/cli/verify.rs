//! `satseed verify`

use super::Exit;
use super::args::VerifyArgs;

pub(crate) fn run(_args: &VerifyArgs) -> anyhow::Result<Exit> {
    anyhow::bail!("verify is not built yet")
}
