//! The recipes that come with the program.

/// A recipe that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// Its text, as it stands in `presets/`.
    pub text: &'static str,
}

/// All presets, in the order that they are listed in.
pub const PRESETS: &[Preset] = &[
    Preset { name: "quickstart", text: include_str!("../../presets/quickstart.toml") },
    Preset { name: "satunreal", text: include_str!("../../presets/satunreal.toml") },
    Preset { name: "satseed", text: include_str!("../../presets/satseed.toml") },
    Preset { name: "lowtexture", text: include_str!("../../presets/lowtexture.toml") },
    Preset { name: "ablation", text: include_str!("../../presets/ablation.toml") },
    Preset { name: "canyon", text: include_str!("../../presets/canyon.toml") },
    Preset { name: "toronto", text: include_str!("../../presets/toronto.toml") },
    Preset { name: "desert", text: include_str!("../../presets/desert.toml") },
    Preset { name: "field", text: include_str!("../../presets/field.toml") },
    Preset { name: "forest", text: include_str!("../../presets/forest.toml") },
    Preset { name: "coast", text: include_str!("../../presets/coast.toml") },
    Preset { name: "california", text: include_str!("../../presets/california.toml") },
    Preset { name: "venice", text: include_str!("../../presets/venice.toml") },
];

impl Preset {
    /// The preset of a name.
    pub fn by_name(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// What it is for: its text's first comment.
    pub fn summary(&self) -> String {
        let comment = self.text.lines().map_while(|line| line.strip_prefix('#'));
        comment.take_while(|line| !line.trim().is_empty()).map(str::trim).collect::<Vec<_>>().join(" ")
    }
}
