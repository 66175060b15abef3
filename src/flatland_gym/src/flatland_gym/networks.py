"""Small networks in NumPy with their gradients, the scale of their input, and Adam."""

from typing import List, Sequence, Tuple

import numpy as np

from flatland_server import Float32Array, FloatArray

Arrays = List[Float32Array]


class Network:
    """Layers with tanh between them.

    Args:
        sizes: of the input, of each hidden layer, and of the output.
        gain: of the last layer's initial weights.
        rng: draws the initial weights: orthogonal, which is known to help PPO.
    """

    def __init__(self, sizes: Sequence[int], gain: float, rng: np.random.Generator) -> None:
        self.weights: Arrays = []
        self.biases: Arrays = []
        for number, (rows, columns) in enumerate(zip(sizes[:-1], sizes[1:])):
            is_last = number == len(sizes) - 2
            scale = gain if is_last else np.sqrt(2.0)
            self.weights.append((scale * _orthogonal(rows, columns, rng)).astype(np.float32))
            self.biases.append(np.zeros(columns, np.float32))

    @property
    def parameters(self) -> Arrays:
        """Weights and biases, to be changed in place."""
        return [*self.weights, *self.biases]

    def forward(self, inputs: Float32Array) -> Arrays:
        """The inputs and the outputs of all layers: shape (n, size) each."""
        return layer_values(self.weights, self.biases, inputs)

    def backward(self, values: Arrays, gradient: Float32Array) -> Arrays:
        """The gradients of the parameters, in their order.

        Args:
            values: what `forward` has returned.
            gradient: of the output, shape (n, size).
        """
        weights: Arrays = []
        biases: Arrays = []
        for number in range(len(self.weights) - 1, -1, -1):
            weights.insert(0, values[number].T @ gradient)
            biases.insert(0, gradient.sum(axis=0))
            if number:
                gradient = (gradient @ self.weights[number].T) * (1.0 - values[number] ** 2)
        return [*weights, *biases]


def layer_values(
    weights: Sequence[Float32Array], biases: Sequence[Float32Array], inputs: Float32Array
) -> Arrays:
    """The inputs and the outputs of all layers of a network: shape (n, size) each."""
    values = [inputs]
    for number, (weight, bias) in enumerate(zip(weights, biases)):
        value = values[-1] @ weight + bias
        values.append(np.tanh(value) if number < len(weights) - 1 else value)
    return values


class Adam:
    """Adam (Kingma and Ba, 2015), with the gradients' common norm limited.

    Args:
        parameters: changed in place by `step`.
        max_norm: of all gradients together.
    """

    def __init__(self, parameters: Arrays, max_norm: float = 0.5) -> None:
        self._parameters = parameters
        self._means = [np.zeros_like(each) for each in parameters]
        self._squares = [np.zeros_like(each) for each in parameters]
        self._max_norm = max_norm
        self._count = 0

    def step(self, gradients: Arrays, rate: float) -> None:
        """Makes a step of gradient descent."""
        self._count += 1
        norm = float(np.sqrt(sum(float((each**2).sum()) for each in gradients)))
        factor = np.float32(min(1.0, self._max_norm / (norm + 1e-8)))
        correction = np.sqrt(1.0 - 0.999**self._count) / (1.0 - 0.9**self._count)
        for parameter, gradient, mean, square in zip(
            self._parameters, gradients, self._means, self._squares
        ):
            scaled = gradient * factor
            mean += np.float32(0.1) * (scaled - mean)
            square += np.float32(0.001) * (scaled * scaled - square)
            parameter -= np.float32(rate * correction) * mean / (np.sqrt(square) + np.float32(1e-8))


def _orthogonal(rows: int, columns: int, rng: np.random.Generator) -> Float32Array:
    """A matrix with orthonormal rows or columns."""
    matrix = rng.normal(size=(max(rows, columns), min(rows, columns)))
    q, r = np.linalg.qr(matrix)
    q *= np.sign(np.diag(r))
    return q if rows >= columns else q.T  # type: ignore[no-any-return]


class Scale:
    """Normalises observations by their means and standard deviations so far.

    Args:
        size: of an observation.
    """

    _LEAST = 0.05  # standard deviation

    def __init__(self, size: int) -> None:
        self._count = 0
        self._mean, self._variance = np.zeros(size), np.zeros(size)
        self._set(np.zeros(size), np.ones(size))

    @property
    def is_known(self) -> bool:
        """True if it has learnt from rows."""
        return self._count > 0

    def of(self, rows: Float32Array) -> Float32Array:
        """Normalised observations."""
        return (rows - self._shift) / self._width

    def take(self, rows: Float32Array) -> None:
        """Learns from normalised observations; those before count as well."""
        mean = self._shift + self._width * rows.mean(axis=0, dtype=np.float64)
        variance = self._width**2 * rows.var(axis=0, dtype=np.float64)
        part = len(rows) / (self._count + len(rows))
        away = mean - self._mean
        self._mean += part * away
        self._variance += part * (variance - self._variance + (1.0 - part) * away**2)
        self._count += len(rows)
        self._set(self._mean, np.maximum(np.sqrt(self._variance), self._LEAST))

    def folded(
        self, weights: Float32Array, biases: Float32Array
    ) -> Tuple[Float32Array, Float32Array]:
        """A first layer for observations as they are."""
        scaled = weights / self._width[:, None]
        return scaled, biases - self._shift @ scaled

    def _set(self, shift: FloatArray, width: FloatArray) -> None:
        self._shift, self._width = shift.astype(np.float32), width.astype(np.float32)
