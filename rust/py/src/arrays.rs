//! The checks of all arrays that come from Python. An array that does not have the right form raises a
//! ValueError that names the argument, what was found and what is needed. Nothing is converted.

use std::fmt::Display;
use std::ops::Range;

use numpy::{
    Element, PyArrayDescrMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods, dtype,
};
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use crate::errors::value_error;
use crate::scalars::{LARGEST, text_of};

/// A number type of arrays.
pub trait Number: Element + Copy + Display {
    /// False for NaN, infinity and what is larger than `LARGEST`.
    fn is_sound(self) -> bool;
}

impl Number for f32 {
    fn is_sound(self) -> bool {
        self.abs() <= LARGEST as f32
    }
}

impl Number for f64 {
    fn is_sound(self) -> bool {
        self.abs() <= LARGEST
    }
}

impl Number for i32 {
    fn is_sound(self) -> bool {
        true
    }
}

impl Number for bool {
    fn is_sound(self) -> bool {
        true
    }
}

/// One length of a shape. Letters are those of the stub.
#[derive(Clone, Copy)]
pub enum Length {
    /// This length.
    Exactly(usize),
    /// Any length; messages call it by this letter.
    Any(char),
    /// This length; messages call it by this letter.
    Named(char, usize),
}

/// The shape that an argument must have.
pub struct Shape<'a>(pub &'a [Length]);

impl Shape<'_> {
    fn admits(&self, shape: &[usize]) -> bool {
        let fits = |(length, &found): (&Length, &usize)| match *length {
            Length::Exactly(expected) | Length::Named(_, expected) => expected == found,
            Length::Any(_) => true,
        };
        self.0.len() == shape.len() && self.0.iter().zip(shape).all(fits)
    }
}

impl Display for Shape<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut lengths = Vec::new();
        let mut meanings = Vec::new();
        for length in self.0 {
            match *length {
                Length::Exactly(expected) => lengths.push(expected.to_string()),
                Length::Any(letter) => lengths.push(letter.to_string()),
                Length::Named(letter, expected) => {
                    lengths.push(letter.to_string());
                    meanings.push(format!(" with {letter} = {expected}"));
                }
            }
        }
        let comma = if lengths.len() == 1 { "," } else { "" };
        write!(formatter, "({}{comma}){}", lengths.join(", "), meanings.concat())
    }
}

/// An array to read.
pub struct Input<'py, T: Number> {
    name: &'static str,
    borrow: PyReadonlyArrayDyn<'py, T>,
}

/// An array to write.
pub struct Output<'py, T: Number> {
    name: &'static str,
    array: Bound<'py, PyArrayDyn<T>>,
}

/// A borrowed output.
pub struct OutputView<'py, T: Number>(PyReadwriteArrayDyn<'py, T>);

impl<'py, T: Number> Input<'py, T> {
    /// Checks that the argument `name` is an array of `shape`, in C order, of numbers up to `LARGEST`.
    pub fn new(name: &'static str, argument: &Bound<'py, PyAny>, shape: Shape) -> PyResult<Self> {
        let array = array_of::<T>(name, argument, &shape)?;
        let borrow = array
            .try_readonly()
            .map_err(|_| value_error(format!("{name}: the array is being written by another call")))?;
        let input = Self { name, borrow };
        let numbers = input.numbers()?;
        match numbers.iter().position(|number| !number.is_sound()) {
            None => Ok(input),
            Some(index) => Err(value_error(format!(
                "{name}: expected numbers from -{LARGEST:e} to {LARGEST:e}, got {} at entry {index} of the flattened array",
                numbers[index]
            ))),
        }
    }

    /// All numbers, in C order.
    pub fn numbers(&self) -> PyResult<&[T]> {
        self.borrow
            .as_slice()
            .map_err(|error| value_error(format!("{}: {error}", self.name)))
    }

    /// The numbers in groups of `N`, the product of the last lengths.
    pub fn groups<const N: usize>(&self) -> PyResult<&[[T; N]]> {
        Ok(self.numbers()?.as_chunks().0)
    }

    fn memory(&self) -> PyResult<(&'static str, Range<usize>)> {
        let numbers = self.numbers()?.as_ptr_range();
        Ok((self.name, numbers.start as usize..numbers.end as usize))
    }
}

impl<'py, T: Number> Output<'py, T> {
    /// Checks that the argument `name` is a writable array of `shape`, in C order.
    pub fn new(name: &'static str, argument: &Bound<'py, PyAny>, shape: Shape) -> PyResult<Self> {
        let array = array_of::<T>(name, argument, &shape)?;
        let flags = array.getattr("flags")?;
        if flags.getattr("writeable")?.is_truthy()? {
            Ok(Self { name, array })
        } else {
            Err(value_error(format!(
                "{name}: expected a writeable array, got a read-only one"
            )))
        }
    }

    /// Borrows the array for writing. Its memory must not overlap that of `inputs`.
    pub fn view(self, inputs: &[&dyn Memory]) -> PyResult<OutputView<'py, T>> {
        let start = self.array.data() as usize;
        let memory = start..start + self.array.len() * size_of::<T>();
        for input in inputs {
            let (other, input_memory) = input.memory()?;
            if memory.start < input_memory.end && input_memory.start < memory.end {
                let name = self.name;
                return Err(value_error(format!(
                    "{name}: expected an array with separate memory, got one that overlaps {other}"
                )));
            }
        }
        let in_use = |_| value_error(format!("{}: the array is in use by another call", self.name));
        self.array.try_readwrite().map(OutputView).map_err(in_use)
    }
}

impl<T: Number> OutputView<'_, T> {
    /// The numbers in groups of `N`, to write.
    pub fn groups<const N: usize>(&mut self) -> PyResult<&mut [[T; N]]> {
        let numbers = self
            .0
            .as_slice_mut()
            .map_err(|error| value_error(error.to_string()))?;
        Ok(numbers.as_chunks_mut().0)
    }
}

/// The name and memory of an input.
pub trait Memory {
    /// The name, and the range of addresses.
    fn memory(&self) -> PyResult<(&'static str, Range<usize>)>;
}

impl<T: Number> Memory for Input<'_, T> {
    fn memory(&self) -> PyResult<(&'static str, Range<usize>)> {
        Input::memory(self)
    }
}

/// `N` numbers up to `LARGEST` from any sequence: a tuple, a list, a mathutils vector.
pub fn numbers_of<const N: usize>(name: &'static str, argument: &Bound<'_, PyAny>) -> PyResult<[f64; N]> {
    let refused = |_| {
        let found = text_of(argument);
        value_error(format!(
            "{name}: expected {N} numbers from -{LARGEST:e} to {LARGEST:e}, got {found}"
        ))
    };
    let numbers = argument
        .try_iter()
        .and_then(|items| {
            items
                .take(N + 1)
                .map(|item| item?.extract::<f64>())
                .collect::<PyResult<Vec<_>>>()
        })
        .map_err(refused)?;
    let numbers = <[f64; N]>::try_from(numbers).map_err(|_| refused(value_error(String::new())))?;
    if numbers.iter().all(|number| number.is_sound()) {
        Ok(numbers)
    } else {
        Err(refused(value_error(String::new())))
    }
}

fn array_of<'py, T: Number>(
    name: &'static str,
    argument: &Bound<'py, PyAny>,
    shape: &Shape,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let expected = dtype::<T>(argument.py());
    let refused = |found: String| {
        value_error(format!(
            "{name}: expected {expected} array of shape {shape} in C order, got {found}"
        ))
    };
    let Ok(array) = argument.cast::<PyUntypedArray>() else {
        return Err(refused(format!("a {}", argument.get_type().name()?)));
    };
    let found_type = array.dtype();
    let found = format!("{found_type} {}", tuple(array.shape()));
    if found_type.byteorder() == foreign_byte_order() {
        return Err(refused(format!("{found} in foreign byte order")));
    }
    if !found_type.is_equiv_to(&expected) || !shape.admits(array.shape()) {
        return Err(refused(found));
    }
    if !array.is_c_contiguous() {
        let order = if array.is_fortran_contiguous() {
            "in Fortran order"
        } else {
            "not contiguous"
        };
        return Err(refused(format!("{found} {order}")));
    }
    if !array.getattr("flags")?.getattr("aligned")?.is_truthy()? {
        return Err(refused(format!("{found} not aligned in memory")));
    }
    Ok(array.cast::<PyArrayDyn<T>>()?.clone())
}

fn foreign_byte_order() -> u8 {
    if cfg!(target_endian = "little") {
        b'>'
    } else {
        b'<'
    }
}

fn tuple(shape: &[usize]) -> String {
    let comma = if shape.len() == 1 { "," } else { "" };
    format!(
        "({}{comma})",
        shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
    )
}
