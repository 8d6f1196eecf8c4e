//! The weights: matrices by name, in a safetensors file.

use motes_networks::{Parameters, Precision};
use safetensors::tensor::{SafeTensors, TensorView};
use safetensors::{Dtype, serialize};

/// A named matrix as it was read.
pub(super) struct Matrix {
    name: String,
    shape: [usize; 2],
    /// Row-major; finite.
    pub(super) values: Vec<f64>,
}

/// The file for some parameters, in their own precision.
pub(super) fn encode(parameters: &Parameters) -> Result<Vec<u8>, String> {
    let (dtype, wide) = match parameters.compute().precision {
        Precision::F32 => (Dtype::F32, false),
        Precision::F64 => (Dtype::F64, true),
    };
    let mut matrices = Vec::new();
    for (index, name) in parameters.names().iter().enumerate() {
        let values = parameters.host(index);
        let bytes: Vec<u8> = if wide {
            values.iter().flat_map(|value| value.to_le_bytes()).collect()
        } else {
            values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect()
        };
        matrices.push((name.clone(), parameters.shape(index), bytes));
    }
    let unwritten = |error: safetensors::SafeTensorError| format!("the weights cannot be written: {error}");
    let views = matrices.iter().map(|(name, shape, bytes)| {
        TensorView::new(dtype, shape.to_vec(), bytes).map(|view| (name.clone(), view))
    });
    let views = views.collect::<Result<Vec<_>, _>>().map_err(unwritten)?;
    serialize(views, None).map_err(unwritten)
}

/// Reads the file; every value must be finite.
pub(super) fn decode(bytes: &[u8]) -> Result<Vec<Matrix>, String> {
    let file =
        SafeTensors::deserialize(bytes).map_err(|error| format!("it is not a safetensors file: {error}"))?;
    file.tensors().into_iter().map(|(name, view)| matrix(name, &view)).collect()
}

fn matrix(name: String, view: &TensorView<'_>) -> Result<Matrix, String> {
    let Ok(shape) = <[usize; 2]>::try_from(view.shape().to_vec()) else {
        return Err(format!("{name} has {} dimensions instead of 2", view.shape().len()));
    };
    let values: Vec<f64> = match view.dtype() {
        Dtype::F32 => view.data().as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect(),
        Dtype::F64 => view.data().as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        other => return Err(format!("{name} holds {other:?} instead of F32 or F64")),
    };
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(Matrix { name, shape, values }),
        Some(at) => {
            let (row, column) = (at / shape[1], at % shape[1]);
            Err(format!("{name} holds {} at row {row}, column {column}", values[at]))
        }
    }
}

/// Sets every parameter from the matrix of its name.
pub(super) fn place(matrices: &[Matrix], parameters: &mut Parameters) -> Result<(), String> {
    if matrices.len() != parameters.len() {
        return Err(format!("it has {} matrices instead of {}", matrices.len(), parameters.len()));
    }
    for index in 0..parameters.len() {
        let name = &parameters.names()[index];
        let Some(matrix) = matrices.iter().find(|matrix| matrix.name == *name) else {
            return Err(format!("it has no matrix {name}"));
        };
        let expected = parameters.shape(index);
        if matrix.shape != expected {
            return Err(format!("{name} is {:?} instead of {expected:?}", matrix.shape));
        }
        parameters.set_host(index, &matrix.values).map_err(|error| error.to_string())?;
    }
    Ok(())
}
