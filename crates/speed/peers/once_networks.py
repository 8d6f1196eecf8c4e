"""The networks of proposals that are learned once, in 32 bits: tanh layers with a linear path beside them."""

import json
import os

import jax.numpy as jnp
import numpy as np
from safetensors.numpy import load_file


def weights_of(folder, name):
    """The weights of one network, `initial` or `later`, and the means and scales of its inputs."""
    weights = load_file(os.path.join(folder, "weights.safetensors"))
    of_network = {key[len(name) + 1 :]: value for key, value in weights.items() if key.startswith(f"{name}.")}
    standards = [of_network.pop(f"inputs.{which}").reshape(-1) for which in ("means", "scales")]
    return {key: value.astype(np.float32) for key, value in of_network.items()}, standards


def problem_of(folder):
    with open(os.path.join(folder, "problem.json"), encoding="utf-8") as file:
        return json.load(file)


def pairs_of(folder, name, n):
    """States, a row each coordinate."""
    return np.fromfile(os.path.join(folder, f"{name}.f64"), dtype="<f8").reshape(-1, n).T


def theta_of_rows(weights, inputs):
    """One row of inputs and of outputs a particle."""
    hidden = jnp.tanh(inputs @ weights["0.weight"] + weights["0.bias"])
    hidden = jnp.tanh(hidden @ weights["1.weight"] + weights["1.bias"])
    return hidden @ weights["outputs.weight"] + inputs @ weights["outputs.linear"] + weights["outputs.bias"]


def theta_of_columns(weights, inputs):
    """One column a particle, so that what heads do reads whole rows."""

    def affine(name, values):
        return weights[f"{name}.weight"].T @ values

    hidden = jnp.tanh(affine("0", inputs) + weights["0.bias"].T)
    hidden = jnp.tanh(affine("1", hidden) + weights["1.bias"].T)
    linear = weights["outputs.linear"].T @ inputs
    return affine("outputs", hidden) + linear + weights["outputs.bias"].T
