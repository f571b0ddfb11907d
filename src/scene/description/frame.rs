//! In which form a scene is described.

use strum::{IntoStaticStr, VariantArray};

/// Kinds of description of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Frame {
    /// Gaps and motion seen from the ego.
    Ego,
    /// Positions on the map.
    Cartesian,
    /// Safety measures of all obstacles near.
    Metrics,
    /// What one obstacle and the ego did, and the road.
    Trajectory,
    /// A picture from above, with what is needed to read it.
    Picture,
    /// [`Frame::Ego`], and the picture.
    #[strum(to_string = "ego+picture")]
    EgoPicture,
    /// [`Frame::Cartesian`], and the picture.
    #[strum(to_string = "cartesian+picture")]
    CartesianPicture,
    /// [`Frame::Metrics`], and the picture.
    #[strum(to_string = "metrics+picture")]
    MetricsPicture,
    /// [`Frame::Trajectory`], and the picture.
    #[strum(to_string = "trajectory+picture")]
    TrajectoryPicture,
}

nearmiss_record::named!(Frame, "frame");

impl Frame {
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

    /// The names of every frame, for help and errors.
    #[must_use]
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }
}
