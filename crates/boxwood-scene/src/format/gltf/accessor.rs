//! Accessors: typed, strided, maybe sparse views of the bytes.

use super::Source;
use super::buffers::{View, slice};
use crate::LoadError;

/// Most elements of an accessor that has no bytes of its own (all zero, then sparse).
const MAX_ZEROS: u64 = 1 << 20;

/// The types of glTF numbers, by the codes of OpenGL.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// A number that accessors are read as.
pub(super) trait Number: Copy + Default {
    /// `bytes` has the size of `component`. `None` if this number is not stored that way.
    fn read(component: u32, normalized: bool, bytes: &[u8]) -> Option<Self>;
}

impl Number for u32 {
    fn read(component: u32, _: bool, bytes: &[u8]) -> Option<Self> {
        match (Component::from_code(component)?, bytes) {
            (Component::U8, &[a]) => Some(a.into()),
            (Component::U16, &[a, b]) => Some(u16::from_le_bytes([a, b]).into()),
            (Component::U32, &[a, b, c, d]) => Some(Self::from_le_bytes([a, b, c, d])),
            _ => None,
        }
    }
}

impl Number for f32 {
    /// Whole numbers as `KHR_mesh_quantization` allows them: as they are, or normalised to -1..1 or 0..1.
    fn read(component: u32, normalized: bool, bytes: &[u8]) -> Option<Self> {
        let (value, largest) = match (Component::from_code(component)?, bytes) {
            (Component::F32, &[a, b, c, d]) => return Some(Self::from_le_bytes([a, b, c, d])),
            (Component::I8, &[a]) => (Self::from(a.cast_signed()), 127.0),
            (Component::U8, &[a]) => (Self::from(a), 255.0),
            (Component::I16, &[a, b]) => (Self::from(i16::from_le_bytes([a, b])), 32_767.0),
            (Component::U16, &[a, b]) => (Self::from(u16::from_le_bytes([a, b])), 65_535.0),
            _ => return None,
        };
        Some(if normalized {
            (value / largest).max(-1.0)
        } else {
            value
        })
    }
}

/// The checked elements of an accessor, `N` numbers each.
pub(super) struct Elements<'a, T, const N: usize> {
    /// The first element begins here; empty where all are zero.
    bytes: &'a [u8],
    stride: usize,
    component: u32,
    normalized: bool,
    count: usize,
    /// Replaced elements, ascending.
    patches: Vec<(u32, [T; N])>,
}

impl<T: Number, const N: usize> Elements<'_, T, N> {
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// How many elements a sparse accessor replaces.
    pub(super) fn patch_count(&self) -> usize {
        self.patches.len()
    }

    /// Element `i`, which is below [`Elements::count`]. Zero if the file has none there.
    pub(super) fn get(&self, i: u32) -> [T; N] {
        if let Ok(found) = self.patches.binary_search_by_key(&i, |patch| patch.0) {
            return self.patches[found].1;
        }
        let element = self
            .bytes
            .get(i as usize * self.stride..)
            .unwrap_or_default();
        element_at(element, self.component, self.normalized).unwrap_or([T::default(); N])
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = [T; N]> {
        (0..self.count as u32).map(|i| self.get(i))
    }
}

/// The element that `bytes` begins with.
fn element_at<T: Number, const N: usize>(
    bytes: &[u8],
    component: u32,
    normalized: bool,
) -> Option<[T; N]> {
    let size = Component::from_code(component)?.size();
    let bytes = bytes.get(..N * size)?;
    let mut element = [T::default(); N];
    for (number, bytes) in element.iter_mut().zip(bytes.chunks_exact(size)) {
        *number = T::read(component, normalized, bytes)?;
    }
    Some(element)
}

impl Source<'_> {
    /// The accessor `index`, which `user` (a path) refers to and which holds `what` (a plural).
    ///
    /// Nothing is copied but sparse patches; that all elements lie within their bytes is made sure of here, once.
    pub(super) fn elements<T: Number, const N: usize>(
        &self,
        index: u32,
        user: &str,
        what: &str,
    ) -> Result<Elements<'_, T, N>, LoadError> {
        let accessors = &self.document.accessors;
        let Some(accessor) = accessors.get(index as usize) else {
            return Err(self.fault(
                user,
                format!("refers to accessor {index} of {}", accessors.len()),
            ));
        };
        let path = format!("accessors[{index}]");
        let shape = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        if accessor.shape.as_str() != shape {
            let cause = format!(
                "{what} are {shape}, this is \"{}\"",
                accessor.shape.as_str()
            );
            return Err(self.fault(path, cause));
        }
        let component = Component::from_code(accessor.component_type).filter(|component| {
            T::read(accessor.component_type, false, &[0; 4][..component.size()]).is_some()
        });
        let Some(component) = component else {
            return Err(self.fault(
                path,
                format!(
                    "{what} cannot have component type {}",
                    accessor.component_type
                ),
            ));
        };
        let Ok(count) = u32::try_from(accessor.count) else {
            return Err(self.fault(
                path,
                format!("{} {what} are more than 2^32", accessor.count),
            ));
        };

        let size = N * component.size();
        let mut elements = Elements {
            bytes: &[],
            stride: size,
            component: accessor.component_type,
            normalized: accessor.normalized,
            count: count as usize,
            patches: Vec::new(),
        };
        match accessor.buffer_view {
            Some(view) => {
                let view = self.view(view, &path)?;
                elements.stride = view.stride.map_or(size, |stride| stride as usize);
                if elements.stride < size {
                    let cause = format!("{what} of {size} bytes every {} bytes", elements.stride);
                    return Err(self.fault(path, cause));
                }
                let needed = span(count.into(), elements.stride as u64, size as u64);
                elements.bytes = self.part(
                    &view,
                    accessor.byte_offset,
                    needed,
                    count.into(),
                    what,
                    &path,
                )?;
            }
            None if u64::from(count) > MAX_ZEROS => {
                let cause =
                    format!("{count} {what} without a buffer view, the limit is {MAX_ZEROS}");
                return Err(self.fault(path, cause));
            }
            None => {}
        }
        elements.patches = self.patches(index, what)?;
        Ok(elements)
    }

    /// The replaced elements of a sparse accessor.
    fn patches<T: Number, const N: usize>(
        &self,
        index: u32,
        what: &str,
    ) -> Result<Vec<(u32, [T; N])>, LoadError> {
        let accessor = &self.document.accessors[index as usize];
        let Some(sparse) = &accessor.sparse else {
            return Ok(Vec::new());
        };
        let path = format!("accessors[{index}].sparse");
        let sizes = (
            Component::from_code(sparse.indices.component_type),
            Component::from_code(accessor.component_type),
        );
        let (Some(key), Some(component)) = sizes else {
            let cause = format!(
                "indices cannot have component type {}",
                sparse.indices.component_type
            );
            return Err(self.fault(path, cause));
        };
        let size = N * component.size();

        let view = self.view(sparse.indices.buffer_view, &path)?;
        let needed = span(sparse.count, key.size() as u64, key.size() as u64);
        let keys = self.part(
            &view,
            sparse.indices.byte_offset,
            needed,
            sparse.count,
            "indices",
            &path,
        )?;
        let view = self.view(sparse.values.buffer_view, &path)?;
        let needed = span(sparse.count, size as u64, size as u64);
        let values = self.part(
            &view,
            sparse.values.byte_offset,
            needed,
            sparse.count,
            what,
            &path,
        )?;

        let mut patches: Vec<(u32, [T; N])> = Vec::with_capacity(keys.len() / key.size());
        for (bytes, value) in keys.chunks_exact(key.size()).zip(values.chunks_exact(size)) {
            let i = u32::read(sparse.indices.component_type, false, bytes);
            let value = element_at(value, accessor.component_type, accessor.normalized);
            match (i, value) {
                (Some(i), Some(value)) if u64::from(i) < accessor.count => {
                    if patches.last().is_some_and(|last| last.0 >= i) {
                        return Err(self.fault(path, format!("its indices do not ascend at {i}")));
                    }
                    patches.push((i, value));
                }
                (Some(i), _) => {
                    return Err(
                        self.fault(path, format!("replaces element {i} of {}", accessor.count))
                    );
                }
                (None, _) => {
                    return Err(self.fault(path, "its indices are not unsigned whole numbers"));
                }
            }
        }
        Ok(patches)
    }

    /// `needed` bytes of a view from `offset` on; `None` stands for a number beyond 2^64.
    fn part<'a>(
        &self,
        view: &View<'a>,
        offset: u64,
        needed: Option<u64>,
        count: u64,
        what: &str,
        path: &str,
    ) -> Result<&'a [u8], LoadError> {
        let part = needed.and_then(|needed| slice(view.bytes, offset, needed));
        part.ok_or_else(|| {
            let needed = needed.map_or("more than 2^64".to_owned(), |needed| needed.to_string());
            let from = if offset > 0 {
                format!(" from {offset} on")
            } else {
                String::new()
            };
            let cause = format!(
                "{count} {what} need {needed} bytes{from}, the buffer view has {}",
                view.bytes.len()
            );
            self.fault(path, cause)
        })
    }
}

/// Bytes from the first to behind the last of `count` elements.
fn span(count: u64, stride: u64, size: u64) -> Option<u64> {
    match count {
        0 => Some(0),
        _ => stride.checked_mul(count - 1)?.checked_add(size),
    }
}
