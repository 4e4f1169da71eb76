use super::*;

/// A tree as a test builds it.
#[derive(Clone, Debug)]
enum Tree {
    Unknown,
    Free,
    Occupied,
    Inner(Vec<Tree>),
}

impl Tree {
    fn random(random: &mut fastrand::Rng, level: u32) -> Self {
        match random.u32(0..10) {
            0 | 1 if level > 0 => Self::Unknown,
            2 if level > 12 => Self::Free,
            3 if level > 12 => Self::Occupied,
            // Few branches to the finest cells.
            _ if level < DEPTH => {
                let kept = if level < 13 {
                    1 + random.usize(0..2)
                } else {
                    8
                };
                let mut children = vec![Self::Unknown; 8];
                for _ in 0..kept {
                    children[random.usize(0..8)] = Self::random(random, level + 1);
                }
                Self::Inner(children)
            }
            number if number % 2 == 0 => Self::Free,
            _ => Self::Occupied,
        }
    }

    fn is_empty_inner(&self) -> bool {
        matches!(self, Self::Inner(children) if children.iter().all(|child| matches!(child, Self::Unknown)))
    }

    /// Nodes without children are leaves, which only `.ot` can say of a node that was one.
    fn tidy(self) -> Self {
        match self {
            Self::Inner(children) => {
                let children: Vec<Self> = children.into_iter().map(Self::tidy).collect();
                let whole = Self::Inner(children);
                if whole.is_empty_inner() {
                    Self::Occupied
                } else {
                    whole
                }
            }
            other @ (Self::Unknown | Self::Free | Self::Occupied) => other,
        }
    }

    fn count(&self) -> usize {
        match self {
            Self::Unknown => 0,
            Self::Free | Self::Occupied => 1,
            Self::Inner(children) => 1 + children.iter().map(Self::count).sum::<usize>(),
        }
    }

    /// As OctoMap's `writeBinaryNode` does.
    fn binary(&self, out: &mut Vec<u8>) {
        let Self::Inner(children) = self else { return };
        let bits = |child: &Self| match child {
            Self::Unknown => 0b00,
            Self::Free => 0b01,
            Self::Occupied => 0b10,
            Self::Inner(_) => 0b11,
        };
        for half in children.chunks(4) {
            let byte = half
                .iter()
                .enumerate()
                .map(|(index, child)| bits(child) << (2 * index));
            out.push(byte.fold(0, |all, bits| all | bits));
        }
        children
            .iter()
            .for_each(|child| child.binary(out));
    }

    /// As OctoMap's `writeNodesRecurs` does.
    fn full(&self, out: &mut Vec<u8>) {
        let (value, children): (f32, &[Self]) = match self {
            Self::Unknown => return,
            Self::Free => (-0.4, &[]),
            Self::Occupied => (0.0, &[]),
            Self::Inner(children) => (-2.0, children),
        };
        out.extend(value.to_le_bytes());
        let is_there = |child: &Self| !matches!(child, Self::Unknown);
        let bits = children.iter().enumerate();
        out.push(bits.fold(0, |all, (index, child)| {
            all | u8::from(is_there(child)) << index
        }));
        children
            .iter()
            .for_each(|child| child.full(out));
    }

    /// Leaves: centre and edge in cells, and whether they are occupied.
    fn leaves(&self, center: [f64; 3], edge: f64, found: &mut Vec<([f64; 3], f64, bool)>) {
        match self {
            Self::Unknown => {}
            Self::Free => found.push((center, edge, false)),
            Self::Occupied => found.push((center, edge, true)),
            Self::Inner(children) => {
                for (index, child) in children.iter().enumerate() {
                    let side =
                        |axis: usize| edge / 4.0 * if index >> axis & 1 == 1 { 1.0 } else { -1.0 };
                    let center = [0, 1, 2].map(|axis| center[axis] + side(axis));
                    child.leaves(center, edge / 2.0, found);
                }
            }
        }
    }
}

fn file(kind: &str, id: &str, tree: &Tree, data: &[u8]) -> Vec<u8> {
    let size = tree.count();
    let header =
        format!("# Octomap OcTree {kind}\n# a comment\nid {id}\nsize {size}\nres 0.0625\ndata\n");
    [header.as_bytes(), data].concat()
}

fn written(tree: &Tree) -> [Vec<u8>; 2] {
    let mut binary = Vec::new();
    tree.binary(&mut binary);
    let mut full = Vec::new();
    tree.full(&mut full);
    [
        file("binary file", "OcTree", tree, &binary),
        file("file", "OcTree", tree, &full),
    ]
}

#[test]
fn both_forms_give_every_leaf_at_its_place() {
    let mut random = fastrand::Rng::with_seed(7);
    for _ in 0..20 {
        let tree = Tree::random(&mut random, 0).tidy();
        if !matches!(tree, Tree::Inner(_)) {
            continue;
        }
        let mut wanted = Vec::new();
        tree.leaves([0.0; 3], f64::from(EDGE), &mut wanted);
        for bytes in written(&tree) {
            let map = Octomap::read("a", &bytes).unwrap();
            assert_eq!(map.count(), tree.count());
            let told = |cells: Vec<Cell>| -> Vec<([f64; 3], f64)> {
                let told = |cell| {
                    (
                        (map.center(cell) / 0.0625).to_array(),
                        map.size(cell) / 0.0625,
                    )
                };
                cells.into_iter().map(told).collect()
            };
            let of = |occupied: bool| -> Vec<([f64; 3], f64)> {
                let leaves = wanted.iter().filter(|leaf| leaf.2 == occupied);
                leaves.map(|leaf| (leaf.0, leaf.1)).collect()
            };
            assert_eq!(told(map.occupied()), of(true));
            assert_eq!(told(map.free()), of(false));
            let cells = [map.occupied(), map.free(), map.unknown()].concat();
            let volume: u64 = cells.iter().map(|cell| cell.volume()).sum();
            assert_eq!(volume, Cell::ROOT.volume(), "what is not known is unknown");
        }
    }
}

fn sample() -> Tree {
    let mut tree = Tree::Occupied;
    for _ in 0..DEPTH {
        let mut children = vec![Tree::Unknown; 8];
        children[0] = tree;
        children[6] = Tree::Free;
        tree = Tree::Inner(children);
    }
    tree
}

#[test]
fn what_is_unknown_is_counted_within_what_is_known() {
    let mut children = vec![Tree::Unknown; 8];
    children[0] = Tree::Occupied;
    children[7] = Tree::Free;
    let tree = Tree::Inner(children);
    let map = Octomap::read("a", &written(&tree)[0]).unwrap();
    assert_eq!(map.unknown_within(), 6 * Cell::ROOT.volume() / 8);
    let nothing = Octomap::of_stream(Stream::Full, "OcTree", 0.1, &[]).unwrap();
    assert_eq!((nothing.count(), nothing.unknown_within()), (0, 0));
    assert_eq!(nothing.unknown(), [Cell::ROOT]);
}

fn refusal(bytes: &[u8]) -> String {
    Octomap::read("hall.bt", bytes).unwrap_err()
}

#[test]
fn other_trees_and_damaged_files_are_refused_by_name() {
    let tree = sample();
    let [binary, full] = written(&tree);
    for cut in [1, 20] {
        let text = refusal(&binary[..binary.len() - cut]);
        assert!(
            text.contains("octomap hall.bt: cut short: its tree goes on at byte"),
            "{text}"
        );
        assert!(refusal(&full[..full.len() - cut]).contains("cut short"));
    }
    assert!(refusal(&binary[..70]).contains("its header ends in line"));
    let more = [binary.as_slice(), b"abc"].concat();
    assert!(refusal(&more).contains("3 bytes follow its tree"));
    let header = |from: &str, to: &str| {
        let end = binary.len() - 2 * DEPTH as usize;
        let text = String::from_utf8(binary[..end].to_vec()).unwrap();
        assert!(text.contains(from));
        [text.replace(from, to).as_bytes(), &binary[end..]].concat()
    };
    assert!(refusal(&header("size 33", "size 34")).contains("says 34 nodes, 33 are there"));
    assert!(refusal(&header("res 0.0625", "res 0")).contains("resolution is 0; it must"));
    assert!(refusal(&header("size", "sise")).contains("line 4: \"sise\" is no word"));
    let colored = file("file", "ColorOcTree", &tree, &[]);
    assert!(refusal(&colored).contains("kind \"ColorOcTree\", only \"OcTree\" is read"));
    assert!(refusal(b"ply\n").contains("it is no octomap"));
}
