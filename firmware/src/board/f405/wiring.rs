//! What is wired to which pin, and at what rate it runs. Nothing else in the image names a pin or a rate of this
//! board.

use stm32f4xx_hal::gpio::PA9;

/// The crystal, MHz.
pub const CRYSTAL_MHZ: u32 = 8;
/// The core's clock, MHz.
pub const CORE_MHZ: u32 = 168;

/// USART1_TX: the results.
pub type ResultsTx = PA9;
/// The rate of the results' line, baud: a tick's result is about 150 bytes, so 200 Hz fill a third of it.
pub const RESULTS_BAUD: u32 = 921_600;
