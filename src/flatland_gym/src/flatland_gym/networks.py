"""Small networks in NumPy, with their gradients, and the optimiser Adam."""

from typing import List, Sequence, Tuple

import numpy as np

from flatland_server import Float32Array

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
        weights, biases, _ = _gradients(self.weights, values, gradient)
        return [*weights, *biases]

    def layers(self) -> Tuple[Arrays, Arrays]:
        """Copies of the weights and biases of layers that are fully connected."""
        return [each.copy() for each in self.weights], [each.copy() for each in self.biases]


class SetNetwork(Network):
    """A network to which the last part of its inputs is a set: members of equal size, in any order.

    Each member passes the same layer, together with the numbers before the set; the sum of its
    outputs joins the first hidden layer (M. Zaheer et al., "Deep Sets", NeurIPS 2017). What is
    learnt of one member holds for all of them, which takes fewer steps.

    Args:
        sizes: of the input, of one hidden layer or more, and of the output.
        gain: of the last layer's initial weights.
        rng: draws the initial weights.
        members: their number and their size.
        context: how many numbers before the set each member is seen with.
    """

    def __init__(
        self,
        sizes: Sequence[int],
        gain: float,
        rng: np.random.Generator,
        members: Tuple[int, int],
        context: int,
    ) -> None:
        self._count, size = members
        self._own, self._context = sizes[0] - self._count * size, context
        self._width = sizes[1] // 2
        super().__init__((self._own, *sizes[1:]), gain, rng)
        member = np.sqrt(2.0) * _orthogonal(context + size, self._width, rng)
        joining = np.sqrt(2.0 / self._count) * _orthogonal(self._width, sizes[2], rng)
        self.weights[1] = np.concatenate([self.weights[1], joining.astype(np.float32)])
        self.weights.append(member.astype(np.float32))
        self.biases.append(np.zeros(self._width, np.float32))

    def forward(self, inputs: Float32Array) -> Arrays:
        """The values of all layers, those of the output last."""
        own, shape = inputs[:, : self._own], (len(inputs) * self._count, -1)
        context = np.repeat(own[:, self._own - self._context :], self._count, axis=0)
        members = np.concatenate([context, inputs[:, self._own :].reshape(shape)], axis=1)
        outputs = np.tanh(members @ self.weights[-1] + self.biases[-1])
        hidden = np.tanh(own @ self.weights[0] + self.biases[0])
        total = outputs.reshape(len(inputs), self._count, self._width).sum(axis=1)
        joined = np.concatenate([hidden, total], axis=1)
        later = layer_values(self.weights[1:-1], self.biases[1:-1], joined)
        return [members, outputs, own, *later]

    def backward(self, values: Arrays, gradient: Float32Array) -> Arrays:
        members, outputs, own, *later = values
        weights, biases, gradient = _gradients(self.weights[1:-1], later, gradient)
        gradient = gradient @ self.weights[1].T
        hidden = later[0][:, : -self._width]
        of_hidden = gradient[:, : -self._width] * (1.0 - hidden**2)
        each = np.repeat(gradient[:, -self._width :], self._count, axis=0) * (1.0 - outputs**2)
        weights = [own.T @ of_hidden, *weights, members.T @ each]
        return [*weights, of_hidden.sum(axis=0), *biases, each.sum(axis=0)]

    def layers(self) -> Tuple[Arrays, Arrays]:
        weights, biases = self.weights, self.biases
        count, (rows, hidden) = self._count, weights[0].shape
        size = len(weights[-1]) - self._context
        first = np.zeros((rows + count * size, hidden + count * self._width), np.float32)
        first[:rows, :hidden] = weights[0]
        first[rows - self._context : rows, hidden:] = np.tile(
            weights[-1][: self._context], (1, count)
        )
        first[rows:, hidden:] = np.kron(np.eye(count), weights[-1][self._context :])
        second = [weights[1][:hidden], *[weights[1][hidden:]] * count]
        biases_of_first = np.concatenate([biases[0], np.tile(biases[-1], count)])
        later = [each.copy() for each in weights[2:-1]]
        return (
            [first, np.concatenate(second), *later],
            [biases_of_first, *(each.copy() for each in biases[1:-1])],
        )


def layer_values(
    weights: Sequence[Float32Array], biases: Sequence[Float32Array], inputs: Float32Array
) -> Arrays:
    """The inputs and the outputs of all layers of a network: shape (n, size) each."""
    values = [inputs]
    for number, (weight, bias) in enumerate(zip(weights, biases)):
        value = values[-1] @ weight + bias
        values.append(np.tanh(value) if number < len(weights) - 1 else value)
    return values


def _gradients(
    layers: Sequence[Float32Array], values: Arrays, gradient: Float32Array
) -> Tuple[Arrays, Arrays, Float32Array]:
    """The gradients of weights and biases, and that of the first layer's sums."""
    weights: Arrays = []
    biases: Arrays = []
    for number in range(len(layers) - 1, -1, -1):
        weights.insert(0, values[number].T @ gradient)
        biases.insert(0, gradient.sum(axis=0))
        if number:
            gradient = (gradient @ layers[number].T) * (1.0 - values[number] ** 2)
    return weights, biases, gradient


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
