//! A technique's settings: one list for their keys, types, defaults and meanings.

/// Makes the table of settings (`TABLE`), and the struct that has them with their types: a field and a row
/// each.
///
/// A row is `field: type = "key", kind, Value|Rule "default", "unit", "meaning", read;`, where `read(values,
/// key)` is the typed value, or `None`.
macro_rules! settings {
    ($(#[doc = $about:literal])+ $name:ident;
        $($(#[doc = $doc:literal])+ $field:ident: $type:ty = $key:literal, $kind:expr,
        $preset:ident $default:literal, $unit:literal, $meaning:literal, $read:expr;)+) => {
        /// The table of settings.
        pub(super) const TABLE: &[$crate::setting::Setting] =
            &[$($crate::setting::table::row!($key: $kind, $preset $default, $unit, $meaning)),+];

        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $($(#[doc = $doc])+ pub $field: $type,)+
        }

        impl $name {
            /// The typed settings of checked values.
            ///
            /// # Errors
            ///
            /// If values of another technique lack a key.
            pub fn of(values: &$crate::setting::Values) -> Result<Self, $crate::run::Refusal> {
                let typed = || Some(Self { $($field: ($read)(values, $key)?,)+ });
                typed().ok_or_else(|| $crate::run::Refusal::new("settings of another technique"))
            }
        }
    };
}

pub(crate) use settings;
