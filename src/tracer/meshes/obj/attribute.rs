//! Normals and texture coordinates of an OBJ file: the values of their lines, and which value each corner of a face
//! uses.

use std::num::IntErrorKind;

use crate::error::quoted;
use crate::tracer::meshes::Mesh;
use crate::tracer::meshes::line::{Line, LineError};

/// Something that faces refer to by index, as messages name it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Referent {
    one: &'static str,
    many: &'static str,
    /// An index of it in a face.
    index: &'static str,
}

pub(super) const VERTEX: Referent = Referent { one: "vertex", many: "vertices", index: "face index" };
const TEXTURE: Referent =
    Referent { one: "texture coordinate", many: "texture coordinates", index: "texture coordinate index" };
const NORMAL: Referent = Referent { one: "normal", many: "normals", index: "normal index" };

/// The largest index that a face used before the file defined what it refers to.
#[derive(Debug, Default)]
pub(super) struct ForwardIndices(Option<ForwardIndex>);

/// An index, counted from 1, and the face that uses it.
#[derive(Debug)]
struct ForwardIndex {
    index: usize,
    line: usize,
    text: String,
}

impl ForwardIndices {
    /// The place that an index of a face refers to, counted from 0. `known` is how many the file has defined so far.
    pub(super) fn resolve(
        &mut self,
        referent: &Referent,
        known: usize,
        line: &Line<'_>,
        word: &[u8],
    ) -> Result<usize, LineError> {
        let Referent { one, many, index: name } = referent;
        let error = |what: &str| line.error(&format!("{name} {what}"));
        let text = str::from_utf8(word).map_err(|_| error("is not a whole number"))?;
        // tobj parses indices as isize too.
        let index = text.parse::<isize>().map_err(|failure| match failure.kind() {
            IntErrorKind::Empty => error("is missing"),
            IntErrorKind::PosOverflow | IntErrorKind::NegOverflow => error("is out of range"),
            _ => error("is not a whole number"),
        })?;
        match index {
            0 => Err(error(&format!("is 0, but the first {one} is 1"))),
            ..0 => known
                .checked_sub(index.unsigned_abs())
                .ok_or_else(|| error(&format!("{index} counts back beyond the {known} {many} so far"))),
            1.. => {
                let index = index.unsigned_abs();
                if index > self.0.as_ref().map_or(0, |forward| forward.index).max(known) {
                    self.0 = Some(ForwardIndex { index, line: line.number, text: quoted(line.text) });
                }
                Ok(index - 1)
            }
        }
    }

    /// Checks at the end of the file that everything has been defined.
    pub(super) fn check_end(&self, referent: &Referent, known: usize) -> Result<(), LineError> {
        match &self.0 {
            Some(ForwardIndex { index, line, text }) if *index > known => Err(LineError {
                line: *line,
                message: format!("there is no {} {index}, the file has {known}: {text}", referent.one),
            }),
            _ => Ok(()),
        }
    }
}

/// Values of `N` numbers, and the corners that use them.
#[derive(Debug)]
pub(super) struct Attribute<const N: usize> {
    referent: Referent,
    /// Fewer numbers than this are an error. Those that are missing are 0.
    least_numbers: usize,
    /// A value that cannot be read is NaN.
    values: Vec<[f32; N]>,
    /// The index of each value that cannot be read, and why. It is no error unless a face uses the value.
    broken: Vec<(usize, LineError)>,
    /// For each corner so far of each face, the value that it uses, or [`Mesh::NO_VALUE`]. Empty as long as no corner
    /// uses one.
    corners: Vec<u32>,
    forward: ForwardIndices,
}

impl Attribute<3> {
    pub(super) fn normals() -> Self {
        Self::new(NORMAL, 3)
    }
}

impl Attribute<2> {
    /// A line may hold one number, and a third one, which does not count.
    pub(super) fn texture_coordinates() -> Self {
        Self::new(TEXTURE, 1)
    }
}

impl<const N: usize> Attribute<N> {
    fn new(referent: Referent, least_numbers: usize) -> Self {
        let forward = ForwardIndices::default();
        Self { referent, least_numbers, values: Vec::new(), broken: Vec::new(), corners: Vec::new(), forward }
    }

    /// Adds the value of a line.
    pub(super) fn add_value(&mut self, line: &Line<'_>) {
        let value = self.parse(line).unwrap_or_else(|error| {
            self.broken.push((self.values.len(), error));
            [f32::NAN; N]
        });
        self.values.push(value);
    }

    fn parse(&self, line: &Line<'_>) -> Result<[f32; N], LineError> {
        let mut value = [0.0; N];
        let mut numbers = 0;
        for (number, word) in value.iter_mut().zip(line.arguments()) {
            *number = line.finite(self.referent.one, word)?;
            numbers += 1;
        }
        if numbers < self.least_numbers {
            let plural = if self.least_numbers == 1 { "" } else { "s" };
            return Err(line.error(&format!("a {} needs {} number{plural}", self.referent.one, self.least_numbers)));
        }
        Ok(value)
    }

    /// Adds the next corner. `word` is its index, or empty if it has none. `corners` corners come before it.
    pub(super) fn add_corner(&mut self, line: &Line<'_>, word: &[u8], corners: usize) -> Result<(), LineError> {
        if !word.is_empty() {
            let value = self.forward.resolve(&self.referent, self.values.len(), line, word)?;
            self.corners.resize(corners, Mesh::NO_VALUE);
            // An index beyond u32 is beyond every file too. check_end refuses it.
            self.corners.push(u32::try_from(value).unwrap_or(Mesh::NO_VALUE));
        } else if !self.corners.is_empty() {
            self.corners.push(Mesh::NO_VALUE);
        }
        Ok(())
    }

    /// Checks that all values that corners use exist and can be read.
    pub(super) fn check_end(&mut self) -> Result<(), LineError> {
        self.forward.check_end(&self.referent, self.values.len())?;
        if self.broken.is_empty() {
            return Ok(());
        }
        let is_broken = |&&value: &&u32| value != Mesh::NO_VALUE && self.values[value as usize][0].is_nan();
        let Some(&value) = self.corners.iter().find(is_broken) else { return Ok(()) };
        let place = self.broken.binary_search_by_key(&(value as usize), |(index, _)| *index);
        Err(self.broken.swap_remove(place.expect("the reason is known")).1)
    }

    pub(super) fn is_used(&self) -> bool {
        !self.corners.is_empty()
    }

    /// The values, and those of each triangle. `triangles` holds numbers of corners, counted over the whole file. A
    /// triangle has values only if its three corners have.
    pub(super) fn of_triangles<T: From<[f32; N]>>(self, triangles: &[[u32; 3]]) -> (Vec<T>, Vec<[u32; 3]>) {
        let corners = triangles.iter().map(|triangle| {
            let values = triangle.map(|corner| self.corners.get(corner as usize).copied().unwrap_or(Mesh::NO_VALUE));
            if values.contains(&Mesh::NO_VALUE) { [Mesh::NO_VALUE; 3] } else { values }
        });
        let corners = corners.collect();
        (self.values.into_iter().map(T::from).collect(), corners)
    }
}
