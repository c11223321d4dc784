//! Work of a technique's stages: one list for counters and their names.

/// Makes the struct of counters (`Work`), with their names.
macro_rules! work {
    ($($(#[doc = $doc:literal])+ $field:ident,)+) => {
        /// Work of a stage: plain fields, since the innermost loops count in them.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct Work {
            $($(#[doc = $doc])+ pub $field: u64,)+
        }

        impl std::ops::AddAssign for Work {
            fn add_assign(&mut self, other: Self) {
                $(self.$field += other.$field;)+
            }
        }

        impl Work {
            /// Counts the rays of a search.
            pub fn add_rays(&mut self, counters: $crate::geometry::TraversalCounters) {
                self.rays += counters.rays;
            }

            /// The work by name, as far as there is any.
            pub fn counters(&self) -> $crate::run::Counters {
                let mut counters = $crate::run::Counters::default();
                $(if self.$field > 0 {
                    counters.add(stringify!($field), self.$field);
                })+
                counters
            }
        }
    };
}

pub(crate) use work;
