//! The door for the integration tests of this repository: all rooms, without any promise.

/// Opens rooms: each as a module with everything that is public in it.
macro_rules! open {
    ($($room:ident),*) => {$(
        pub mod $room {
            pub use crate::$room::*;
        }
    )*};
}

open!(
    approximation,
    film,
    generate,
    geometry,
    method,
    metric,
    mitsuba,
    numeric,
    optics,
    radiometry,
    reference,
    run,
    scene,
    setting,
    spectrum,
    study,
    transport
);
