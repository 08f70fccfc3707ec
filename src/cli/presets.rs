//! `satseed presets`

use super::Exit;
use super::args::{PresetsArgs, PresetsCommand};
use super::output::write_stdout;
use anyhow::Context as _;
use satseed::recipe::{PRESETS, Preset, schema};

pub(crate) fn run(args: &PresetsArgs) -> anyhow::Result<Exit> {
    match &args.command {
        None | Some(PresetsCommand::List) => write_stdout(|out| {
            let width = PRESETS.iter().map(|p| p.name.len()).max().unwrap_or(0);
            PRESETS.iter().try_for_each(|p| writeln!(out, "{:width$}  {}", p.name, p.summary()))
        })?,
        Some(PresetsCommand::Schema) => write_stdout(|out| {
            serde_json::to_writer_pretty(&mut *out, &schema())?;
            writeln!(out)
        })?,
        Some(PresetsCommand::Show { name }) => {
            let preset = Preset::by_name(name).with_context(|| {
                let names: Vec<_> = PRESETS.iter().map(|p| p.name).collect();
                format!("there is no preset {name:?}; presets are {}", names.join(", "))
            })?;
            write_stdout(|out| out.write_all(preset.text.as_bytes()))?;
        }
    }
    Ok(Exit::Fine)
}
