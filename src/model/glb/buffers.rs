//! The binary chunk: one run of bytes for each kind of array, and the accessors into them.

use super::document::{Accessor, BufferView};

const FLOAT: u32 = 5126;
const BYTE: u32 = 5121;
const SHORT: u32 = 5123;
const INT: u32 = 5125;
const VERTICES: u32 = 34962;
const TRIANGLES: u32 = 34963;

/// A kind of array; each has a buffer view of its own, so that all accessors of a kind share one stride.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Run {
    Positions,
    Normals,
    Colours,
    Shorts,
    Ints,
}

const RUNS: [Run; 5] = [Run::Positions, Run::Normals, Run::Colours, Run::Ints, Run::Shorts];

/// Arrays under way to the binary chunk.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    runs: [Vec<u8>; RUNS.len()],
    accessors: Vec<(Run, Accessor)>,
}

impl Buffers {
    /// Vertices, m; with the bounds that the format wants.
    pub(super) fn positions(&mut self, values: &[[f32; 3]]) -> u32 {
        let bounds = |pick: fn(f32, f32) -> f32| {
            values.iter().copied().reduce(|a, b| core::array::from_fn(|k| pick(a[k], b[k])))
        };
        let (min, max) = (bounds(f32::min), bounds(f32::max));
        let id = self.push(Run::Positions, "VEC3", values.len(), &bytes_of(values));
        let accessor = &mut self.accessors[id as usize].1;
        (accessor.min, accessor.max) = (min, max);
        id
    }

    /// Unit normals. What a generator rounds is put right, since the format wants them unit to f32.
    pub(super) fn normals(&mut self, values: &[[f32; 3]]) -> u32 {
        let unit: Vec<[f32; 3]> = values
            .iter()
            .map(|n| {
                let n = glam::DVec3::from_array(n.map(f64::from));
                n.try_normalize().unwrap_or(glam::DVec3::Z).to_array().map(|x| x as f32)
            })
            .collect();
        self.push(Run::Normals, "VEC3", values.len(), &bytes_of(&unit))
    }

    /// Colours in 255ths; the fourth is opacity, which keeps vertices on multiples of 4 bytes.
    pub(super) fn colours(&mut self, values: &[[u8; 4]]) -> u32 {
        self.push(Run::Colours, "VEC4", values.len(), values.as_flattened())
    }

    /// Corners of triangles, as indices of `vertices` vertices.
    pub(super) fn indices(&mut self, values: &[u32], vertices: usize) -> u32 {
        // 65,536 vertices would need the index 65,535, which means a restart.
        if u16::try_from(vertices).is_ok() {
            let bytes: Vec<u8> = values.iter().flat_map(|v| (*v as u16).to_le_bytes()).collect();
            self.push(Run::Shorts, "SCALAR", values.len(), &bytes)
        } else {
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            self.push(Run::Ints, "SCALAR", values.len(), &bytes)
        }
    }

    fn push(&mut self, run: Run, kind: &'static str, count: usize, bytes: &[u8]) -> u32 {
        let all = &mut self.runs[place(run)];
        let byte_offset = all.len() as u64;
        all.extend_from_slice(bytes);
        let (component_type, normalized) = match run {
            Run::Positions | Run::Normals => (FLOAT, false),
            Run::Colours => (BYTE, true),
            Run::Shorts => (SHORT, false),
            Run::Ints => (INT, false),
        };
        let (min, max) = (None, None);
        // The buffer view's number is known when it is known which there are.
        let accessor = Accessor { buffer_view: 0, byte_offset, component_type, normalized, count, kind, min, max };
        self.accessors.push((run, accessor));
        self.accessors.len() as u32 - 1
    }

    /// Accessors, buffer views and the chunk itself, a multiple of 4 bytes.
    pub(super) fn finish(self) -> (Vec<Accessor>, Vec<BufferView>, Vec<u8>) {
        let mut views = Vec::new();
        let mut binary = Vec::with_capacity(self.runs.iter().map(Vec::len).sum::<usize>() + 4);
        let mut numbers = [0; RUNS.len()];
        // Shorts come last: all others are multiples of 4 bytes long.
        for run in RUNS {
            let bytes = &self.runs[place(run)];
            if bytes.is_empty() {
                continue;
            }
            numbers[place(run)] = views.len() as u32;
            let (byte_stride, target) = match run {
                Run::Positions | Run::Normals => (Some(12), VERTICES),
                Run::Colours => (Some(4), VERTICES),
                Run::Shorts | Run::Ints => (None, TRIANGLES),
            };
            let (byte_offset, byte_length) = (binary.len() as u64, bytes.len() as u64);
            views.push(BufferView { buffer: 0, byte_offset, byte_length, byte_stride, target });
            binary.extend_from_slice(bytes);
        }
        binary.resize(binary.len().next_multiple_of(4), 0);
        let number = |(run, a): (Run, Accessor)| Accessor { buffer_view: numbers[place(run)], ..a };
        (self.accessors.into_iter().map(number).collect(), views, binary)
    }
}

fn place(run: Run) -> usize {
    run as usize
}

fn bytes_of(values: &[[f32; 3]]) -> Vec<u8> {
    values.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}
