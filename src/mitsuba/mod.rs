//! (being built)
/// stub
pub fn load(_path: &std::path::Path, _parameters: &[(String, String)]) -> Result<crate::scene::Scene, std::fmt::Error> { todo!() }
