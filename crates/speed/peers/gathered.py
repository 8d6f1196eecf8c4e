"""Affine maps used at many times, with one product for their weights' gradient instead of a sum of many."""

import torch


class Gathered(torch.autograd.Function):
    """bias + values weight, which leaves inputs and derivatives of outputs in `waiting` for `finish`."""

    waiting = {}

    @staticmethod
    def forward(ctx, bias, values, weight):
        ctx.save_for_backward(values, weight)
        ctx.bias = bias
        return torch.addmm(bias, values, weight)

    @staticmethod
    def backward(ctx, d_output):
        values, weight = ctx.saved_tensors
        Gathered.waiting.setdefault(weight, []).append((ctx.bias, values, d_output))
        d_values = d_output @ weight.T if ctx.needs_input_grad[1] else None
        return None, d_values, None


def affine(bias, values, weight):
    """torch.addmm, with derivatives for weight and bias (one row) by `finish`."""
    return Gathered.apply(bias, values, weight)


def finish():
    """Sets the gradients of all weights and biases that wait for theirs."""
    for weight, uses in Gathered.waiting.items():
        biases, values, d_outputs = zip(*uses)
        d_outputs = d_outputs[0] if len(uses) == 1 else torch.cat(d_outputs)
        values = values[0] if len(uses) == 1 else torch.cat(values)
        weight.grad = values.T @ d_outputs
        if biases[0].requires_grad:
            biases[0].grad = d_outputs.sum(0, keepdim=True)
    Gathered.waiting.clear()
