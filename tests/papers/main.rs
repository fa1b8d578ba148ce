//! Is the equation in the paper what we compute?

mod eq1;
