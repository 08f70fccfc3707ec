//! What a glTF primitive is made of: the triangles of a mesh that share a material slot.

use satseed_scene::Mesh;
use std::collections::BTreeMap;

/// The triangles of one slot with the vertices that they stand on. A vertex where slots meet is in the part of each, for it
/// has the colour of each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// Material slot.
    pub slot: u16,
    /// The mesh's vertices that the part has, ascending.
    pub vertices: Vec<u32>,
    /// The mesh's triangles of this slot, in its order, by places in `vertices`.
    pub triangles: Vec<[u32; 3]>,
}

/// The parts of a mesh, by slot.
pub(super) fn parts(mesh: &Mesh) -> Vec<Part> {
    let mut by_slot: BTreeMap<u16, Vec<[u32; 3]>> = BTreeMap::new();
    for (slot, triangle) in mesh.slots.iter().zip(&mesh.triangles) {
        by_slot.entry(*slot).or_default().push(*triangle);
    }
    // The place of each vertex in the part at hand; overwritten by the next part.
    let mut places = vec![0; mesh.positions_m.len()];
    let part = |(slot, mut triangles): (u16, Vec<[u32; 3]>)| {
        let mut vertices = triangles.as_flattened().to_vec();
        vertices.sort_unstable();
        vertices.dedup();
        for (place, vertex) in (0..).zip(&vertices) {
            places[*vertex as usize] = place;
        }
        for vertex in triangles.as_flattened_mut() {
            *vertex = places[*vertex as usize];
        }
        Part { slot, vertices, triangles }
    };
    by_slot.into_iter().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_is_in_both_parts() {
        let mesh = Mesh {
            positions_m: vec![[0.0; 3]; 6],
            triangles: vec![[5, 4, 2], [2, 4, 0], [4, 5, 0]],
            slots: vec![3, 1, 3],
            ..Mesh::default()
        };
        let parts = parts(&mesh);
        assert_eq!(parts[0], Part { slot: 1, vertices: vec![0, 2, 4], triangles: vec![[1, 2, 0]] });
        assert_eq!(parts[1], Part { slot: 3, vertices: vec![0, 2, 4, 5], triangles: vec![[3, 2, 1], [2, 3, 0]] });
    }
}
