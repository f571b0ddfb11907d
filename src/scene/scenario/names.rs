//! The vocabulary of CommonRoad: enumerations with the names that files use for them.

/// Defines an enumeration whose variants have the names that files use.
macro_rules! names {
    ($(#[$doc:meta])* $name:ident { $($variant:ident = $text:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[allow(missing_docs, reason = "a variant's name is the word of the format")]
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, strum::Display, strum::IntoStaticStr,
            strum::VariantArray,
        )]
        pub enum $name { $(#[strum(to_string = $text)] $variant),+ }

        nearmiss_record::named!($name, "word of CommonRoad");
    };
}

names! {
    /// The marking or barrier at the border of a lanelet.
    LineMarking {
        Dashed = "dashed", Solid = "solid", SolidSolid = "solid_solid",
        DashedDashed = "dashed_dashed", SolidDashed = "solid_dashed",
        DashedSolid = "dashed_solid", Curb = "curb", LoweredCurb = "lowered_curb",
        BroadDashed = "broad_dashed", BroadSolid = "broad_solid",
        NoMarking = "no_marking", Unknown = "unknown",
    }
}

names! {
    /// The kind of road that a lanelet is part of.
    LaneletType {
        Urban = "urban", Country = "country", Highway = "highway", Interstate = "interstate",
        Parking = "parking", DriveWay = "driveWay", MainCarriageWay = "mainCarriageWay",
        AccessRamp = "accessRamp", ExitRamp = "exitRamp", Shoulder = "shoulder",
        BusLane = "busLane", BusStop = "busStop", BicycleLane = "bicycleLane",
        Sidewalk = "sidewalk", Crosswalk = "crosswalk", Restricted = "restricted",
        RestrictedArea = "restricted_area", Intersection = "intersection", Border = "border",
        Tram = "tram", Unknown = "unknown",
    }
}

names! {
    /// Road users that may use a lanelet.
    RoadUser {
        Vehicle = "vehicle", Car = "car", Truck = "truck", Bus = "bus",
        Motorcycle = "motorcycle", Bicycle = "bicycle", Pedestrian = "pedestrian",
        PriorityVehicle = "priorityVehicle", Train = "train", Taxi = "taxi",
    }
}

names! {
    /// The type of an obstacle.
    ObstacleType {
        Unknown = "unknown", Car = "car", Truck = "truck", Bus = "bus", Bicycle = "bicycle",
        Pedestrian = "pedestrian", PriorityVehicle = "priorityVehicle",
        ParkedVehicle = "parkedVehicle", ConstructionZone = "constructionZone", Train = "train",
        RoadBoundary = "roadBoundary", Motorcycle = "motorcycle", Taxi = "taxi",
        Building = "building", Pillar = "pillar", MedianStrip = "median_strip",
    }
}

names! {
    /// The part an obstacle plays.
    ObstacleRole {
        Static = "static", Dynamic = "dynamic", Phantom = "phantom", Environment = "environment",
    }
}

names! {
    /// A colour of a traffic light.
    SignalColor {
        Red = "red", Yellow = "yellow", RedYellow = "redYellow", Green = "green",
        Inactive = "inactive",
    }
}

names! {
    /// The signals of a vehicle.
    Signal {
        Horn = "horn", IndicatorLeft = "indicatorLeft", IndicatorRight = "indicatorRight",
        BrakingLights = "brakingLights", HazardWarningLights = "hazardWarningLights",
        FlashingBlueLights = "flashingBlueLights",
    }
}

names! {
    /// The directions a traffic light is for.
    TrafficDirection {
        Right = "right", Straight = "straight", Left = "left", LeftStraight = "leftStraight",
        StraightRight = "straightRight", LeftRight = "leftRight", All = "all",
    }
}

names! {
    /// A quantity of a state beyond time and position. Metres, radians, seconds.
    StateField {
        Orientation = "orientation", Velocity = "velocity", Acceleration = "acceleration",
        YawRate = "yawRate", SlipAngle = "slipAngle", SteeringAngle = "steeringAngle",
        SteeringAngleSpeed = "steeringAngleSpeed", VelocityY = "velocityY",
        AccelerationY = "accelerationY", RollAngle = "rollAngle", RollRate = "rollRate",
        PitchAngle = "pitchAngle", PitchRate = "pitchRate", PositionZ = "positionZ",
        VelocityZ = "velocityZ", RollAngleFront = "rollAngleFront",
        RollRateFront = "rollRateFront", VelocityYFront = "velocityYFront",
        PositionZFront = "positionZFront", VelocityZFront = "velocityZFront",
        RollAngleRear = "rollAngleRear", RollRateRear = "rollRateRear",
        VelocityYRear = "velocityYRear", PositionZRear = "positionZRear",
        VelocityZRear = "velocityZRear",
        LeftFrontWheelAngularSpeed = "leftFrontWheelAngularSpeed",
        RightFrontWheelAngularSpeed = "rightFrontWheelAngularSpeed",
        LeftRearWheelAngularSpeed = "leftRearWheelAngularSpeed",
        RightRearWheelAngularSpeed = "rightRearWheelAngularSpeed",
        DeltaYFront = "deltaYFront", DeltaYRear = "deltaYRear", Curvature = "curvature",
        CurvatureChange = "curvatureChange", Jerk = "jerk", Jounce = "jounce",
        HitchAngle = "hitchAngle", CurvatureRate = "curvatureRate",
        FrontWheelAngularSpeed = "frontWheelAngularSpeed",
        RearWheelAngularSpeed = "rearWheelAngularSpeed",
        LongitudinalPosition = "longitudinalPosition", LateralPosition = "lateralPosition",
        JerkDot = "jerkDot", KappaDotDot = "kappaDotDot",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back() {
        for marking in LineMarking::ALL {
            assert_eq!(LineMarking::parse(marking.name()), Some(marking));
        }
        for field in StateField::ALL {
            assert_eq!(StateField::parse(field.name()), Some(field));
        }
        assert_eq!(ObstacleType::parse("spaceship"), None);
    }
}
