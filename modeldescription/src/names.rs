//! Enumerations whose values have a name in the XML.

/// Declares an enumeration together with the names its values have in the XML.
macro_rules! named {
    ($(#[$meta:meta])* $type:ident { $($(#[$value_meta:meta])* $value:ident = $name:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
        #[serde(rename_all = "camelCase")]
        pub enum $type { $($(#[$value_meta])* $value,)+ }

        impl $type {
            /// All values, in the standard's order.
            pub const ALL: &'static [$type] = &[$($type::$value,)+];

            /// The name in the XML.
            pub fn name(self) -> &'static str {
                match self { $($type::$value => $name,)+ }
            }

            /// The value with this name in the XML.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|value| value.name() == name)
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

pub(crate) use named;
