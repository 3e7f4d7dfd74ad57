//! The points of a block, and how they lie in memory.

/// Points beyond a block on each side that its stencils reach.
pub const GHOSTS: usize = 3;

/// Blocks of one shape in one, two or three dimensions. Axes that a scene has not have one point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockShape {
    /// Dimensions, 1 to 3.
    pub dims: usize,
    /// Points along each axis: a block owns its lower faces and not its upper ones.
    pub edge: [usize; 3],
    /// Ghost points on each side along each axis.
    pub ghosts: [usize; 3],
    /// Points along each axis, ghosts included.
    pub padded: [usize; 3],
    /// Steps in memory from a point to the next along each axis, ghosts included.
    pub stride: [usize; 3],
    /// Points of a block.
    pub points: usize,
    /// Points of a block, ghosts included.
    pub stored: usize,
}

impl BlockShape {
    /// Blocks of `edge` points along each axis.
    ///
    /// # Panics
    /// If there are no dimensions or more than three, or the edge is odd or less than 4.
    pub fn new(dims: usize, edge: usize) -> Self {
        assert!((1..=3).contains(&dims), "one to three dimensions: {dims}");
        assert!(edge >= 4 && edge.is_multiple_of(2), "an even edge of at least 4 points: {edge}");
        let along = |used, unused| std::array::from_fn(|a| if a < dims { used } else { unused });
        let ghosts = along(GHOSTS, 0);
        let padded = along(edge + 2 * GHOSTS, 1);
        Self {
            dims,
            edge: along(edge, 1),
            ghosts,
            padded,
            stride: [1, padded[0], padded[0] * padded[1]],
            points: edge.pow(dims as u32),
            stored: padded.iter().product(),
        }
    }

    /// Place in memory of a point, counted from the first ghost.
    #[inline]
    pub fn place(&self, at: [usize; 3]) -> usize {
        at[0] + self.stride[1] * at[1] + self.stride[2] * at[2]
    }

    /// The point at a place in memory, both counted from the first ghost.
    #[inline]
    pub fn at(&self, place: usize) -> [usize; 3] {
        let [nx, ny, _] = self.padded;
        [place % nx, place / nx % ny, place / (nx * ny)]
    }

    /// One of the block's own points, counted from the first of them.
    #[inline]
    pub fn own_at(&self, own: usize) -> [usize; 3] {
        let [nx, ny, _] = self.edge;
        [own % nx, own / nx % ny, own / (nx * ny)]
    }

    /// The same, counted from the first ghost.
    #[inline]
    pub fn padded_at(&self, own: usize) -> [usize; 3] {
        let at = self.own_at(own);
        std::array::from_fn(|a| at[a] + self.ghosts[a])
    }

    /// Place of one of the block's own points among all, ghosts included.
    #[inline]
    pub fn padded_place(&self, own: usize) -> usize {
        self.place(self.padded_at(own))
    }

    /// Rows along the first axis of a box of points, counted from the first ghost: the place of
    /// each row's first point. All are as long as the box.
    #[inline]
    pub fn rows(&self, from: [usize; 3], to: [usize; 3]) -> impl Iterator<Item = usize> + use<> {
        let shape = *self;
        (from[2]..to[2])
            .flat_map(move |z| (from[1]..to[1]).map(move |y| shape.place([from[0], y, z])))
    }

    /// The box of the block's own points, counted from the first ghost.
    #[inline]
    pub fn own(&self) -> ([usize; 3], [usize; 3]) {
        (self.ghosts, std::array::from_fn(|a| self.ghosts[a] + self.edge[a]))
    }

    /// Children of a block.
    #[inline]
    pub fn children(&self) -> usize {
        1 << self.dims
    }

    /// Which half of its parent a child is along each axis.
    #[inline]
    pub fn half(&self, child: usize) -> [usize; 3] {
        std::array::from_fn(|a| child >> a & 1)
    }
}
