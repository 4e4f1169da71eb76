//! OctoMap's octrees: which space is occupied, which is free, and which nobody has seen.
//!
//! A tree of 16 levels; its finest cells are cubes of the resolution, and a leaf above stands for
//! all of its cells. `.bt` files have 2 bits for a child (00 unknown, occupied, free, 11 a node of
//! its own), `.ot` files a log-odds number and 8 child bits for a node; a leaf is occupied from
//! log-odds 0 on (probability 0.5), OctoMap's default. Everything that is no leaf is unknown, what lies outside
//! the tree's root cube included (Hornung et al., Autonomous Robots 34, 2013).

#[cfg(test)]
mod tests;

use crate::math::Vec3;

/// Levels below the root.
const DEPTH: u32 = 16;
/// Finest cells from the root's corner to its centre, which is the map's origin.
const CENTER: f64 = (1u32 << (DEPTH - 1)) as f64;
/// Cells along an edge of the root.
const EDGE: u32 = 1 << DEPTH;
/// Most leaves of a map.
const MOST_LEAVES: usize = 1 << 24;

/// A cube of the tree, in finest cells from its root's corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Its corner of least coordinates.
    pub corner: [u32; 3],
    /// Its edge: a power of two.
    pub edge: u32,
}

impl Cell {
    const ROOT: Self = Self {
        corner: [0; 3],
        edge: EDGE,
    };

    /// Its child in OctoMap's order: bit 0 of the index is set on the side of greater x, bit 1 of
    /// greater y, bit 2 of greater z.
    fn child(self, index: usize) -> Self {
        let edge = self.edge / 2;
        let side = |axis: usize| self.corner[axis] + edge * (index as u32 >> axis & 1);
        Self {
            corner: [side(0), side(1), side(2)],
            edge,
        }
    }

    fn volume(self) -> u64 {
        u64::from(self.edge).pow(3)
    }
}

/// What is known of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slot {
    Unknown,
    Free,
    Occupied,
    /// The node of this index has more to say.
    Inner(u32),
}

/// A map as a file or message has it.
#[derive(Clone, Debug)]
pub struct Octomap {
    resolution: f64,
    nodes: Vec<[Slot; 8]>,
    root: Slot,
    /// Nodes that are there, leaves included.
    count: usize,
}

/// How a stream of nodes is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// 2 bits for a child (`.bt`; `binary` in messages).
    Binary,
    /// Log-odds and child bits for a node (`.ot`).
    Full,
}

impl Octomap {
    /// Reads a `.bt` or `.ot` file. `name` is the file as messages call it; the first line says
    /// which it is.
    ///
    /// # Errors
    /// Another kind of file or of tree, a file that is cut short (with the offset), one whose
    /// header says another number of nodes.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self, String> {
        let read = || {
            let (header, data) = Header::read(bytes)?;
            let tree = Self::of_stream(header.stream, &header.id, header.resolution, data)?;
            match tree.count == header.size {
                true => Ok(tree),
                false => Err(format!(
                    "its header says {} nodes, {} are there; it is damaged",
                    header.size, tree.count
                )),
            }
        };
        read().map_err(|reason: String| format!("octomap {name}: {reason}"))
    }

    /// Reads a stream of nodes, as messages (`octomap_msgs/Octomap`) have it without a header.
    /// `id` is the kind of tree, `resolution` the edge of the finest cells (m).
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn of_stream(
        stream: Stream,
        id: &str,
        resolution: f64,
        data: &[u8],
    ) -> Result<Self, String> {
        if id != "OcTree" {
            return Err(format!(
                "it is a tree of kind {id:?}, only \"OcTree\" is read; in OctoMap, copy its leaves into an OcTree"
            ));
        }
        if !(resolution.is_finite() && resolution > 0.0) {
            return Err(format!(
                "its resolution is {resolution}; it must be finite and greater than 0 (metres)"
            ));
        }
        let mut reader = Reader::new(data);
        let root = match (data.is_empty(), stream) {
            (true, _) => Slot::Unknown,
            (false, Stream::Binary) => reader.two_bits(0)?,
            (false, Stream::Full) => reader.log_odds(0)?,
        };
        reader.check_end()?;
        Ok(Self {
            resolution,
            nodes: reader.nodes,
            root,
            count: reader.count,
        })
    }

    /// Edge of the finest cells (m).
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Nodes of the tree, leaves included.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Leaves that are occupied, in the file's order.
    pub fn occupied(&self) -> Vec<Cell> {
        self.all(Slot::Occupied)
    }

    /// Leaves that are free, in the file's order.
    pub fn free(&self) -> Vec<Cell> {
        self.all(Slot::Free)
    }

    /// What is unknown within the root: the largest cubes of the tree that hold no leaf. With the
    /// occupied leaves they are the complement of the free ones.
    pub fn unknown(&self) -> Vec<Cell> {
        self.all(Slot::Unknown)
    }

    /// How many finest cells are unknown in the smallest box around what is known.
    pub fn unknown_within(&self) -> u64 {
        let mut known = 0;
        let mut low = [u32::MAX; 3];
        let mut high = [0; 3];
        self.visit(&mut |cell, slot| {
            if slot == Slot::Unknown {
                return;
            }
            known += cell.volume();
            for axis in 0..3 {
                low[axis] = low[axis].min(cell.corner[axis]);
                high[axis] = high[axis].max(cell.corner[axis] + cell.edge);
            }
        });
        let sizes = (0..3).map(|axis| u64::from(high[axis].saturating_sub(low[axis])));
        sizes.product::<u64>() - known
    }

    /// Centre of a cell in the map's frame (m), to the bit as OctoMap computes it.
    pub fn center(&self, cell: Cell) -> Vec3 {
        let edge = f64::from(cell.edge);
        let steps = Vec3::from_array(
            cell.corner
                .map(|c| (f64::from(c) - CENTER) / edge),
        );
        (steps + Vec3::splat(0.5)) * self.size(cell)
    }

    /// Edge of a cell (m).
    pub fn size(&self, cell: Cell) -> f64 {
        self.resolution * f64::from(cell.edge)
    }

    fn all(&self, wanted: Slot) -> Vec<Cell> {
        let mut cells = Vec::new();
        self.visit(&mut |cell, slot| {
            if slot == wanted {
                cells.push(cell);
            }
        });
        cells
    }

    /// Visits the leaves and what is unknown.
    fn visit(&self, look: &mut impl FnMut(Cell, Slot)) {
        self.visit_below(Cell::ROOT, self.root, look);
    }

    fn visit_below(&self, cell: Cell, slot: Slot, look: &mut impl FnMut(Cell, Slot)) {
        match slot {
            Slot::Inner(node) => {
                for (index, slot) in self.nodes[node as usize].iter().enumerate() {
                    self.visit_below(cell.child(index), *slot, look);
                }
            }
            Slot::Unknown | Slot::Free | Slot::Occupied => look(cell, slot),
        }
    }
}

/// What stands before the tree.
struct Header {
    stream: Stream,
    id: String,
    size: usize,
    resolution: f64,
}

impl Header {
    /// The header, and the bytes after it.
    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        let mut rest = bytes;
        let stream = match next_line(&mut rest) {
            Some("# Octomap OcTree binary file") => Stream::Binary,
            Some("# Octomap OcTree file") => Stream::Full,
            _ => {
                let text = "it is no octomap: its first line is neither \"# Octomap OcTree binary file\" (.bt) nor \"# Octomap OcTree file\" (.ot)";
                return Err(text.to_owned());
            }
        };
        let mut header = Self {
            stream,
            id: String::new(),
            size: 0,
            resolution: f64::NAN,
        };
        let mut line = 1;
        loop {
            line += 1;
            let text = next_line(&mut rest).ok_or_else(|| {
                format!("cut short: its header ends in line {line}, before \"data\"")
            })?;
            if text.trim() == "data" {
                return Ok((header, rest));
            }
            header
                .take(text)
                .map_err(|reason| format!("line {line}: {reason}"))?;
        }
    }

    fn take(&mut self, line: &str) -> Result<(), String> {
        let (word, value) = line
            .trim()
            .split_once(' ')
            .unwrap_or((line.trim(), ""));
        let value = value.trim();
        let bad = |what| format!("{word} is {value:?}, it must be {what}");
        match word {
            "" | "#" => {}
            comment if comment.starts_with('#') => {}
            "id" => value.clone_into(&mut self.id),
            "size" => {
                self.size = value
                    .parse()
                    .map_err(|_| bad("a whole number"))?
            }
            "res" => self.resolution = value.parse().map_err(|_| bad("a number"))?,
            _ => {
                return Err(format!(
                    "{word:?} is no word of its header; valid: id, size, res, data"
                ));
            }
        }
        Ok(())
    }
}

/// Takes a line of text; none where there is no whole one.
fn next_line<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    let end = rest.iter().position(|byte| *byte == b'\n')?;
    let line = std::str::from_utf8(&rest[..end]).ok()?;
    *rest = &rest[end + 1..];
    Some(line.trim_end_matches('\r'))
}

struct Reader<'a> {
    data: &'a [u8],
    at: usize,
    nodes: Vec<[Slot; 8]>,
    count: usize,
}

impl<'a> Reader<'a> {
    fn new(data: &'a [u8]) -> Self {
        Self {
            data,
            at: 0,
            nodes: Vec::new(),
            count: 0,
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let part = self.data.get(self.at..self.at + N);
        let part = part.and_then(|part| part.try_into().ok());
        let part = part.ok_or_else(|| {
            format!(
                "cut short: its tree goes on at byte {} of the {} after the header",
                self.at,
                self.data.len()
            )
        })?;
        self.at += N;
        Ok(part)
    }

    /// Counts a node.
    fn found(&mut self, level: u32) -> Result<(), String> {
        self.count += 1;
        if level > DEPTH {
            return Err(format!(
                "its tree is deeper than {DEPTH} levels at byte {}",
                self.at
            ));
        }
        match self.count > MOST_LEAVES {
            true => Err(format!(
                "it has more than {MOST_LEAVES} nodes; prune it, or take a coarser resolution"
            )),
            false => Ok(()),
        }
    }

    /// Reads a node that has children, of which one without any is an occupied leaf, as OctoMap
    /// reads it.
    fn two_bits(&mut self, level: u32) -> Result<Slot, String> {
        self.found(level)?;
        let bits = u16::from_le_bytes(self.take()?);
        if bits == 0 {
            return Ok(Slot::Occupied);
        }
        let node = self.nodes.len();
        self.nodes.push([Slot::Unknown; 8]);
        for index in 0..8 {
            let slot = match bits >> (2 * index) & 3 {
                0 => Slot::Unknown,
                1 => self.leaf(level, Slot::Free)?,
                2 => self.leaf(level, Slot::Occupied)?,
                _ => Slot::Inner(0),
            };
            self.nodes[node][index] = slot;
        }
        self.descend(node, level, Self::two_bits)
    }

    fn leaf(&mut self, above: u32, slot: Slot) -> Result<Slot, String> {
        self.found(above + 1)?;
        Ok(slot)
    }

    /// Reads the children of a node that are to be read, whose streams follow in their order.
    fn descend(
        &mut self,
        node: usize,
        level: u32,
        read: fn(&mut Self, u32) -> Result<Slot, String>,
    ) -> Result<Slot, String> {
        for index in 0..8 {
            if self.nodes[node][index] == Slot::Inner(0) {
                self.nodes[node][index] = read(self, level + 1)?;
            }
        }
        Ok(Slot::Inner(node as u32))
    }

    fn log_odds(&mut self, level: u32) -> Result<Slot, String> {
        self.found(level)?;
        let value = f32::from_le_bytes(self.take()?);
        let [children] = self.take()?;
        if children != 0 {
            let node = self.nodes.len();
            let slot = |index: u32| match children >> index & 1 {
                0 => Slot::Unknown,
                _ => Slot::Inner(0),
            };
            self.nodes
                .push(std::array::from_fn(|index| slot(index as u32)));
            return self.descend(node, level, Self::log_odds);
        }
        match value {
            value if value.is_nan() => Err(format!(
                "a leaf's log-odds are not a number at byte {} after the header",
                self.at - 5
            )),
            value if value >= 0.0 => Ok(Slot::Occupied),
            _ => Ok(Slot::Free),
        }
    }

    /// Refuses more than a line end after the tree.
    fn check_end(&self) -> Result<(), String> {
        let rest = &self.data[self.at..];
        match rest.trim_ascii().len() {
            0 => Ok(()),
            left => Err(format!("{left} bytes follow its tree; it is damaged")),
        }
    }
}
