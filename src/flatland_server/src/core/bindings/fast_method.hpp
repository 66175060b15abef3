#pragma once

/// Methods that programs call at every step, without pybind11's dispatch.
///
/// Need: pybind11 takes 0.12 us for a call, to choose an overload and convert its arguments. In a
/// world of one robot, that would be a third of a step with its command and its scan.
///
/// Method: Python's own calling convention (METH_FASTCALL) for methods of a class of pybind11.
/// Python checks the type of `self`; the arguments are numbers. Exceptions are translated by
/// pybind11, as for other methods.

#include <algorithm>
#include <array>
#include <exception>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "bindings/bindings.hpp"

namespace flatland {

template <class T>
T ToNumber(PyObject* object);

template <>
inline double ToNumber<double>(PyObject* object) {
  const double value = PyFloat_AsDouble(object);
  if (value == -1.0 && PyErr_Occurred() != nullptr) throw py::error_already_set();
  return value;
}

template <>
inline int ToNumber<int>(PyObject* object) {
  const long value = PyLong_AsLong(object);
  if (value == -1 && PyErr_Occurred() != nullptr) throw py::error_already_set();
  if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
    throw std::overflow_error("expected an int of 32 bits, found " + std::to_string(value));
  }
  return static_cast<int>(value);
}

template <>
inline int64_t ToNumber<int64_t>(PyObject* object) {
  const long long value = PyLong_AsLongLong(object);
  if (value == -1 && PyErr_Occurred() != nullptr) throw py::error_already_set();
  return value;
}

/// Sets Python's error to what pybind11 translates an exception to.
inline void SetError(const std::exception_ptr& exception) {
  try {
    py::cpp_function([&] { std::rethrow_exception(exception); })();
  } catch (py::error_already_set& error) {
    error.restore();
  }
}

/// The C function of a method: calls `function(self, numbers...)`.
template <auto function>
struct FastMethod;

template <class Result, class Self, class... Numbers, Result (*function)(Self&, Numbers...)>
struct FastMethod<function> {
  static constexpr std::size_t kCount = sizeof...(Numbers);
  using Arguments = std::array<PyObject*, kCount>;
  using Names = std::array<const char*, kCount>;
  static inline Names names;

  /// `keywords` are the names of the last arguments, which `positional` does not count; or null.
  static PyObject* Call(PyObject* self, PyObject* const* arguments, Py_ssize_t positional,
                        PyObject* keywords) {
    try {
      Self& object = SelfOf(self);
      const auto indices = std::index_sequence_for<Numbers...>();
      if (keywords == nullptr && positional == static_cast<Py_ssize_t>(kCount)) {
        return Apply(object, arguments, indices);
      }
      return Apply(object, Match(arguments, positional, keywords).data(), indices);
    } catch (...) {
      SetError(std::current_exception());
      return nullptr;
    }
  }

 private:
  static Self& SelfOf(PyObject* self) {
    auto* instance = reinterpret_cast<py::detail::instance*>(self);
    void* const value = instance->get_value_and_holder().value_ptr();
    if (value == nullptr) throw py::type_error("__init__ was not called");
    return *static_cast<Self*>(value);
  }

  /// Returns the arguments in the order of the parameters.
  static Arguments Match(PyObject* const* arguments, Py_ssize_t positional, PyObject* keywords) {
    const Py_ssize_t named = keywords == nullptr ? 0 : PyTuple_GET_SIZE(keywords);
    if (positional + named != static_cast<Py_ssize_t>(kCount)) {
      throw py::type_error("expected " + std::to_string(kCount) + " arguments, found " +
                           std::to_string(positional + named));
    }
    Arguments matched{};
    for (Py_ssize_t i = 0; i < positional; ++i) matched[i] = arguments[i];
    for (Py_ssize_t i = 0; i < named; ++i) {
      const auto name = py::handle(PyTuple_GET_ITEM(keywords, i)).cast<std::string>();
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end() || matched[found - names.begin()] != nullptr) {
        throw py::type_error("unexpected argument " + name);
      }
      matched[found - names.begin()] = arguments[positional + i];
    }
    return matched;
  }

  template <std::size_t... kIndices>
  static PyObject* Apply(Self& self, [[maybe_unused]] PyObject* const* arguments,
                         std::index_sequence<kIndices...>) {
    if constexpr (std::is_void_v<Result>) {
      function(self, ToNumber<Numbers>(arguments[kIndices])...);
      return py::none().release().ptr();
    } else if constexpr (std::is_base_of_v<py::object, Result>) {
      return function(self, ToNumber<Numbers>(arguments[kIndices])...).release().ptr();
    } else {
      return py::cast(function(self, ToNumber<Numbers>(arguments[kIndices])...)).release().ptr();
    }
  }
};

/// Defines a method.
///
/// @param name  of the method
/// @param arguments  their names
template <auto function, class Class, class... Names>
void DefineFast(Class& cls, const char* name, Names... arguments) {
  using Method = FastMethod<function>;
  using Fast = PyObject* (*)(PyObject*, PyObject* const*, Py_ssize_t, PyObject*);
  constexpr Fast kCall = &Method::Call;
  static_assert(sizeof...(arguments) == Method::kCount, "each argument needs a name");
  static PyMethodDef definition{};  // one for a method; Python keeps its address
  Method::names = {arguments...};
  definition.ml_name = name;
  definition.ml_meth = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(kCall));
  definition.ml_flags = METH_FASTCALL | METH_KEYWORDS;
  auto* const type = reinterpret_cast<PyTypeObject*>(cls.ptr());
  cls.attr(name) = py::reinterpret_steal<py::object>(PyDescr_NewMethod(type, &definition));
}

}  // namespace flatland
