/// A point of a surface, as a ray met it.
#[derive(Clone, Debug)]
pub struct Surface {}
