//! Shared helpers of the tests: where the fixtures lie, how images are compared.
