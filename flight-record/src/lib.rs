//! A flight as bytes.
#![no_std]
