//! In which form a scene is described.

/// Kinds of description of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Frame {
    /// Positions on the map.
    Cartesian,
    /// Gaps and motion seen from the ego.
    Ego,
    /// Safety measures of all obstacles near.
    Metrics,
    /// What one obstacle and the ego did, and the road.
    Trajectory,
    /// A picture from above, with what is needed to read it.
    Picture,
    /// [`Frame::Ego`], and the picture.
    EgoPicture,
    /// [`Frame::Cartesian`], and the picture.
    CartesianPicture,
    /// [`Frame::Metrics`], and the picture.
    MetricsPicture,
    /// [`Frame::Trajectory`], and the picture.
    TrajectoryPicture,
}

impl Frame {
    /// Every frame.
    pub const ALL: [Self; 9] = [
        Self::Ego,
        Self::Cartesian,
        Self::Metrics,
        Self::Trajectory,
        Self::Picture,
        Self::EgoPicture,
        Self::CartesianPicture,
        Self::MetricsPicture,
        Self::TrajectoryPicture,
    ];

    /// The word for it, on the command line and in the store.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cartesian => "cartesian",
            Self::Ego => "ego",
            Self::Metrics => "metrics",
            Self::Trajectory => "trajectory",
            Self::Picture => "picture",
            Self::EgoPicture => "ego+picture",
            Self::CartesianPicture => "cartesian+picture",
            Self::MetricsPicture => "metrics+picture",
            Self::TrajectoryPicture => "trajectory+picture",
        }
    }

    /// The frame of its words; `None` for the picture alone.
    #[must_use]
    pub fn words(self) -> Option<Self> {
        match self {
            Self::Picture => None,
            Self::EgoPicture => Some(Self::Ego),
            Self::CartesianPicture => Some(Self::Cartesian),
            Self::MetricsPicture => Some(Self::Metrics),
            Self::TrajectoryPicture => Some(Self::Trajectory),
            words => Some(words),
        }
    }

    /// Whether a picture belongs to it.
    #[must_use]
    pub fn has_picture(self) -> bool {
        self.words() != Some(self)
    }

    /// Whether it is about one obstacle, which has to be named, in times and coordinates of the recording.
    #[must_use]
    pub fn is_of_one_obstacle(self) -> bool {
        self.words() == Some(Self::Trajectory)
    }

    /// Whether positions in it are those on the map, so that north is up in its picture.
    #[must_use]
    pub fn is_on_the_map(self) -> bool {
        matches!(self.words(), Some(Self::Cartesian | Self::Trajectory))
    }

    /// The frame with this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }

    /// The names of every frame, for help and errors.
    #[must_use]
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }
}
