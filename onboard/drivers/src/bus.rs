//! SPI transfers that every chip here uses: a command, or a command and an answer.

use embedded_hal::spi::{Operation, SpiDevice};

use crate::error::SensorError;

/// Sends a command.
///
/// # Errors
/// [`SensorError::Bus`].
pub(crate) fn write(spi: &mut impl SpiDevice, command: &[u8]) -> Result<(), SensorError> {
    spi.write(command).map_err(|_| SensorError::Bus)
}

/// Sends a command and takes the answer.
///
/// # Errors
/// [`SensorError::Bus`].
pub(crate) fn read<const COUNT: usize>(
    spi: &mut impl SpiDevice,
    command: &[u8],
) -> Result<[u8; COUNT], SensorError> {
    let mut answer = [0; COUNT];
    spi.transaction(&mut [Operation::Write(command), Operation::Read(&mut answer)])
        .map_err(|_| SensorError::Bus)?;
    Ok(answer)
}

/// Whether the data line did not move: every bit is 0, or every bit is 1.
pub(crate) fn is_stuck(answer: &[u8]) -> bool {
    let all = |level: u8| answer.iter().all(|&byte| byte == level);
    all(0x00) || all(0xFF)
}

/// Expected traffic on a bus, for tests.
#[cfg(test)]
pub(crate) mod expected {
    use embedded_hal_mock::eh1::spi::Transaction;

    /// A command.
    pub(crate) fn written(command: &[u8]) -> Vec<Transaction<u8>> {
        vec![
            Transaction::transaction_start(),
            Transaction::write_vec(command.to_vec()),
            Transaction::transaction_end(),
        ]
    }

    /// A command and its answer.
    pub(crate) fn read(command: &[u8], answer: &[u8]) -> Vec<Transaction<u8>> {
        vec![
            Transaction::transaction_start(),
            Transaction::write_vec(command.to_vec()),
            Transaction::read_vec(answer.to_vec()),
            Transaction::transaction_end(),
        ]
    }
}
