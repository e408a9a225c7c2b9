//! Typed reads from glTF buffers. Every range is checked before anything is read or allocated.

use crate::Error;
use glam::Vec3;
use gltf::accessor::{DataType, Dimensions};
use gltf::json::Root;
use gltf::json::validation::Checked;
use std::borrow::Cow;

/// The buffers of a file with the document that describes them.
pub(super) struct Buffers<'a> {
    pub(super) bytes: Vec<Cow<'a, [u8]>>,
    pub(super) root: &'a Root,
    pub(super) name: &'a str,
}

impl Buffers<'_> {
    fn error(&self, accessor: usize, problem: impl std::fmt::Display) -> Error {
        let remedy =
            "the file is damaged or unusual: export it again, without sparse or quantised attributes";
        Error::new(self.name, format!("accessors[{accessor}]: {problem}"), remedy)
    }

    /// Three f32 per element.
    pub(super) fn vectors(&self, accessor: usize) -> Result<Vec<Vec3>, Error> {
        let (data_type, elements) = self.elements(accessor, Dimensions::Vec3)?;
        if data_type != DataType::F32 {
            return Err(self.error(accessor, format!("{data_type:?} components, expected F32")));
        }
        let value = |e: &[u8], i: usize| f32::from_le_bytes([e[i], e[i + 1], e[i + 2], e[i + 3]]);
        Ok(elements.map(|e| Vec3::new(value(e, 0), value(e, 4), value(e, 8))).collect())
    }

    /// Unsigned integers of one, two or four bytes.
    pub(super) fn indices(&self, accessor: usize) -> Result<Vec<u32>, Error> {
        let (data_type, elements) = self.elements(accessor, Dimensions::Scalar)?;
        match data_type {
            DataType::U8 => Ok(elements.map(|e| u32::from(e[0])).collect()),
            DataType::U16 => Ok(elements.map(|e| u32::from(u16::from_le_bytes([e[0], e[1]]))).collect()),
            DataType::U32 => Ok(elements.map(|e| u32::from_le_bytes([e[0], e[1], e[2], e[3]])).collect()),
            other => Err(self.error(accessor, format!("{other:?} indices, expected U8, U16 or U32"))),
        }
    }

    /// The component type and the byte slices of an accessor's elements, all of them inside its buffer view.
    fn elements(&self, id: usize, expected: Dimensions) -> Result<(DataType, Elements<'_>), Error> {
        let fail = |problem: &str| self.error(id, problem);
        let accessor = self.root.accessors.get(id).ok_or_else(|| fail("does not exist"))?;
        let Checked::Valid(component) = accessor.component_type else {
            return Err(fail("unknown component type"));
        };
        let Checked::Valid(dimensions) = accessor.type_ else {
            return Err(fail("unknown element type"));
        };
        if dimensions != expected {
            return Err(self.error(id, format!("{dimensions:?} elements, expected {expected:?}")));
        }
        if accessor.sparse.is_some() {
            return Err(fail("sparse accessors are not supported"));
        }
        let view = accessor.buffer_view.ok_or_else(|| fail("has no buffer view"))?;
        let view =
            self.root.buffer_views.get(view.value()).ok_or_else(|| fail("its buffer view does not exist"))?;
        let buffer = self.bytes.get(view.buffer.value()).ok_or_else(|| fail("its buffer does not exist"))?;

        let size = component.0.size() * dimensions.multiplicity();
        let stride = view.byte_stride.map_or(size, |s| s.0);
        let count = usize::try_from(accessor.count.0).map_err(|_| fail("an absurd count"))?;
        let offset = accessor.byte_offset.map_or(0, |o| o.0);
        let inside = || {
            let start = usize::try_from(view.byte_offset.map_or(0, |o| o.0)).ok()?;
            let end = start.checked_add(usize::try_from(view.byte_length.0).ok()?)?;
            let bytes = buffer.get(start..end)?.get(usize::try_from(offset).ok()?..)?;
            let needed =
                count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size))?;
            (stride >= size).then_some(())?;
            bytes.get(..needed)
        };
        let bytes = inside().ok_or_else(|| {
            self.error(
                id,
                format!("{count} elements of {size} bytes, {stride} apart, do not fit into its buffer view"),
            )
        })?;
        Ok((component.0, Elements { bytes, size, stride }))
    }
}

/// Slices of `size` bytes, `stride` apart.
struct Elements<'a> {
    bytes: &'a [u8],
    size: usize,
    stride: usize,
}

impl<'a> Iterator for Elements<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let element = self.bytes.get(..self.size).filter(|e| !e.is_empty())?;
        self.bytes = self.bytes.get(self.stride..).unwrap_or_default();
        Some(element)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let count = self.bytes.len().div_ceil(self.stride.max(1));
        (count, Some(count))
    }
}
