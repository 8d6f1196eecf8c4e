"""Training of learned proposals in PyTorch: eager or compiled, Adam on the log-likelihood of drawn particles."""

import json
import math
import os

import numpy as np
import torch
from safetensors.torch import load_file

import gathered
import proposals


class Loss:
    """Minus the log-likelihood objective of particles drawn along the sequence without resampling."""

    def __init__(self, proposal, problem):
        self.proposal = proposal
        self.wide = torch.float32 if isinstance(proposal, proposals.Psi) else proposals.WIDE
        self.a, self.c, self.y = (problem[name].to(self.wide) for name in ("A", "C", "measurements"))
        self.sigma = problem["sigma"]
        horizon, m = self.y.shape
        n = self.a.shape[0]
        terms = horizon * (n + m) * 0.5 * math.log(2.0 * math.pi)
        self.constant = terms + ((horizon - 1) * n + horizon * m) * math.log(self.sigma)

    def __call__(self, noise):
        states = self.proposal.draw_all(noise)
        initial = (states[0] - 1.0).square().sum()
        steps = (states[1:] - states[:-1] @ self.a.T).square().sum()
        residuals = (self.y.unsqueeze(1) - states @ self.c.T).square().sum()
        total = initial + (steps + residuals) / self.sigma**2
        return total * (0.5 / noise.shape[1]) + self.constant


class Training:
    """One training run: weights, loss, optimiser and noise."""

    def __init__(self, task):
        folder, family, particles = task["folder"], task["family"], task["particles"]
        with open(os.path.join(folder, "problem.json"), encoding="utf-8") as file:
            raw = json.load(file)
        problem = {
            name: torch.tensor(raw[name], dtype=torch.float32)
            for name in ("A", "C", "measurements", "shift", "adapter")
            if name in raw
        }
        problem["sigma"] = float(raw["sigma"])
        weights = load_file(os.path.join(folder, "weights.safetensors"))
        weights = {name: weight.to(torch.float32) for name, weight in weights.items()}
        if family == "psi":
            weights = proposals.stacked_weights_of_psi(weights)
        weights = {name: weight.clone().requires_grad_() for name, weight in weights.items()}
        self.parameters = list(weights.values())
        self.steps, self.uniform = task["steps"], family == "psi"
        self.shape = (problem["measurements"].shape[0], particles, problem["A"].shape[0])
        noise = np.fromfile(os.path.join(folder, "noise.f64"), dtype="<f8").reshape(self.shape)
        self.noise = torch.tensor(noise, dtype=torch.float32)
        compiled = task.get("compile", False)
        affine = torch.addmm if compiled or task.get("gradients") == "plain" else gathered.affine
        self.loss = Loss(proposals.FAMILIES[family](weights, problem, particles, affine), problem)
        if compiled:
            self.loss = torch.compile(self.loss, dynamic=False)
        self.adam = torch.optim.Adam(self.parameters, lr=1e-3, betas=(0.9, 0.999), eps=1e-8, fused=True)
        self.generator = torch.Generator().manual_seed(task.get("seed", 0))
        self.at_first = self.check()

    def gradients(self, noise):
        """Leaves the loss's derivatives in the weights."""
        self.adam.zero_grad(set_to_none=True)
        loss = self.loss(noise)
        loss.backward()
        gathered.finish()
        return loss.detach()

    def check(self):
        """Loss and gradient norm for the noise in the folder, at the current weights."""
        loss = self.gradients(self.noise)
        gradients = [weight.grad for weight in self.parameters if weight.grad is not None]
        norm = math.sqrt(sum(gradient.double().square().sum().item() for gradient in gradients))
        return {"loss": loss.item(), "gradient_norm": norm}

    def run(self, steps):
        """Training steps with fresh noise each."""
        for _ in range(steps):
            draw = torch.rand if self.uniform else torch.randn
            noise = draw(self.shape, generator=self.generator)
            loss = self.gradients(noise)
            self.adam.step()
        return loss.item()
