//! Addresses, sizes and line numbers as types, so that a byte is never taken for a line.

/// A byte address. Any 64-bit value is legal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address(pub u64);

/// A number of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Bytes(pub u64);

/// The size of a line or of a sector: a power of two from 8 to 4096 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LineSize {
    log2: u8,
}

impl LineSize {
    /// The smallest line, 8 bytes.
    pub const MIN: Self = Self { log2: 3 };
    /// The largest line, 4096 bytes.
    pub const MAX: Self = Self { log2: 12 };

    /// A line of `bytes` bytes; `None` unless that is a power of two within [`Self::MIN`] and [`Self::MAX`].
    #[must_use]
    pub const fn new(bytes: u64) -> Option<Self> {
        if bytes.is_power_of_two() && bytes >= Self::MIN.bytes() && bytes <= Self::MAX.bytes() {
            Some(Self { log2: bytes.trailing_zeros() as u8 })
        } else {
            None
        }
    }

    /// The size in bytes.
    #[must_use]
    pub const fn bytes(self) -> u64 {
        1 << self.log2
    }

    /// The base-two logarithm of the size in bytes.
    #[must_use]
    pub const fn log2(self) -> u32 {
        self.log2 as u32
    }

    /// The last line of the address space; its number is all ones.
    #[must_use]
    pub const fn last_line(self) -> LineId {
        self.line_of(Address(u64::MAX))
    }

    /// The line that holds `address`.
    #[must_use]
    pub const fn line_of(self, address: Address) -> LineId {
        LineId(address.0 >> self.log2)
    }
}

/// The number of a line: byte address divided by a [`LineSize`]. It says nothing by itself about which size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct LineId(u64);

impl LineId {
    /// No line of at least 8 bytes has a larger number.
    pub const MAX: Self = Self(u64::MAX >> LineSize::MIN.log2);

    /// The line with this number; bits above [`Self::MAX`], which no address has, are dropped.
    #[must_use]
    pub const fn new(number: u64) -> Self {
        Self(number & Self::MAX.0)
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u64 {
        self.0
    }
}

/// One access to one line: the line and whether it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(transparent)]
pub struct Access(u64);

impl Access {
    const WRITE: u64 = 1 << 63;

    /// A write to `line`, or else a read of it.
    #[must_use]
    pub const fn new(line: LineId, write: bool) -> Self {
        Self(line.0 | (write as u64) << Self::WRITE.trailing_zeros())
    }

    /// A read of `line`.
    #[must_use]
    pub const fn read(line: LineId) -> Self {
        Self::new(line, false)
    }

    /// A write to `line`.
    #[must_use]
    pub const fn write(line: LineId) -> Self {
        Self::new(line, true)
    }

    /// The line.
    #[must_use]
    pub const fn line(self) -> LineId {
        LineId(self.0 & !Self::WRITE)
    }

    /// Whether the line is written.
    #[must_use]
    pub const fn is_write(self) -> bool {
        self.0 & Self::WRITE != 0
    }

    /// The number of the line, and whether it is written.
    pub(crate) const fn parts(self) -> (u64, bool) {
        (self.line().get(), self.is_write())
    }
}
