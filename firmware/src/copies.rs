//! Copies of aligned memory, eight words at a time.
//!
//! The compiler's own runtime copies a word in five instructions, and what a tick takes and says is moved several times: it was a
//! third of all that a tick took. The two functions are those of Arm's run-time ABI (IHI 0043, section 4.3.4); the linker takes them in
//! the place of the runtime's, which are weak. `bin/copy_check.rs` holds every length against a copy byte by byte.

core::arch::global_asm!(
    ".section .text.pylon_copies,\"ax\",%progbits",
    ".syntax unified",
    ".thumb",
    ".p2align 2",
    ".global __aeabi_memcpy8",
    ".type __aeabi_memcpy8,%function",
    ".global __aeabi_memcpy4",
    ".type __aeabi_memcpy4,%function",
    "__aeabi_memcpy8:",
    "__aeabi_memcpy4:",
    // r0: to, r1: from, both at whole words; r2: bytes.
    "push {{r4-r9, lr}}",
    "subs r2, r2, #32",
    "blo 2f",
    "1:",
    "ldmia r1!, {{r3-r9, r12}}",
    "stmia r0!, {{r3-r9, r12}}",
    "subs r2, r2, #32",
    "bhs 1b",
    "2:",
    // What is left are the low five bits: 16 into the carry, 8 into the sign, then 4 and 2, then 1.
    "lsls r2, r2, #28",
    "itt cs",
    "ldmiacs r1!, {{r3-r6}}",
    "stmiacs r0!, {{r3-r6}}",
    "itt mi",
    "ldmiami r1!, {{r3-r4}}",
    "stmiami r0!, {{r3-r4}}",
    "lsls r2, r2, #2",
    "itt cs",
    "ldrcs r3, [r1], #4",
    "strcs r3, [r0], #4",
    "itt mi",
    "ldrhmi r3, [r1], #2",
    "strhmi r3, [r0], #2",
    "lsls r2, r2, #1",
    "itt mi",
    "ldrbmi r3, [r1]",
    "strbmi r3, [r0]",
    "pop {{r4-r9, pc}}",
    ".size __aeabi_memcpy4, . - __aeabi_memcpy4",
);
