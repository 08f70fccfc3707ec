//! The arrays of a sample: which there are, what they hold, and how their files are called.

use super::formats::PixelKind;

/// One of a pair's two views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum View {
    /// The reference view.
    Left,
    /// The other one.
    Right,
}

impl View {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// An array of a view: its image or one of its labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// What the sensor recorded.
    Image,
    /// `u_L - u_R`, px, wherever something was hit.
    Disparity,
    /// 0 miss, 1 valid, 2 occluded, 3 out of frame.
    Validity,
    /// Height above the datum of what is seen, m.
    Elevation,
    /// Semantic class.
    Class,
    /// Object id, 0 is the terrain.
    Instance,
    /// Geometric normal, world frame, times 32767.
    Normal,
    /// Direct sun, 0 to 255.
    Shadow,
    /// 1 where a pixel spans more than 1 px of disparity.
    Edge,
}

impl Layer {
    /// All of them, in the order in which files are listed.
    pub const ALL: [Self; 9] = [
        Self::Image,
        Self::Disparity,
        Self::Validity,
        Self::Elevation,
        Self::Class,
        Self::Instance,
        Self::Normal,
        Self::Shadow,
        Self::Edge,
    ];

    /// What values it may hold: an image what its sensor delivers, a label one kind. The usual kind comes first.
    pub fn kinds(self) -> &'static [PixelKind] {
        use PixelKind::{Bytes4, Counts, Float, Gray, Id, Radiance, Rgb, Vector};
        match self {
            Self::Image => &[Rgb, Gray, Bytes4, Counts(1), Counts(3), Counts(4), Radiance(1), Radiance(3), Radiance(4)],
            Self::Validity | Self::Class | Self::Shadow | Self::Edge => &[Gray],
            Self::Disparity | Self::Elevation => &[Float],
            Self::Instance => &[Id],
            Self::Normal => &[Vector],
        }
    }

    /// Its name in a record's file table: `left`, `disparity_left`.
    pub fn key(self, view: View) -> String {
        let name = match self {
            Self::Image => return view.name().to_owned(),
            Self::Disparity => "disparity",
            Self::Validity => "validity",
            Self::Elevation => "elevation",
            Self::Class => "class",
            Self::Instance => "instance",
            Self::Normal => "normal",
            Self::Shadow => "shadow",
            Self::Edge => "edge",
        };
        format!("{name}_{}", view.name())
    }

    /// The name, in a sample's folder, of its file with values of a kind: `left.png`, `disparity_left.tif`.
    pub fn file_name(self, view: View, kind: PixelKind) -> String {
        format!("{}.{}", self.key(view), kind.extension())
    }

    /// The layer and view of a key in a record's file table.
    pub fn from_key(key: &str) -> Option<(Self, View)> {
        Self::ALL.iter().flat_map(|l| [(*l, View::Left), (*l, View::Right)]).find(|(l, v)| l.key(*v) == key)
    }
}

/// Values of the validity map.
pub mod validity {
    /// Nothing was hit.
    pub const MISS: u8 = 0;
    /// Seen by both.
    pub const VALID: u8 = 1;
    /// In the other frame, but behind something.
    pub const OCCLUDED: u8 = 2;
    /// Beyond the other frame.
    pub const OUT_OF_FRAME: u8 = 3;
}

/// The highest count of an 11-bit image.
pub(super) const LAST_COUNT: u16 = 2047;

/// The highest semantic class.
pub const LAST_CLASS: u8 = 14;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_file_names_are_one_to_one() {
        for layer in Layer::ALL {
            for view in [View::Left, View::Right] {
                assert_eq!(Layer::from_key(&layer.key(view)), Some((layer, view)));
            }
        }
        assert_eq!(Layer::Image.file_name(View::Right, PixelKind::Rgb), "right.png");
        assert_eq!(Layer::Image.file_name(View::Left, PixelKind::Counts(1)), "left.tif");
        assert_eq!(Layer::Disparity.file_name(View::Left, PixelKind::Float), "disparity_left.tif");
        assert_eq!(Layer::from_key("disparity"), None);
    }
}
