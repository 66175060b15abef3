/// Docstrings in Python. They are those of the stub _core.pyi: core_docs.py makes core_docs.inc
/// from it.
///
/// They replace those of pybind11, which list C++ types. This file uses Python's C API alone, so
/// that it compiles quickly after each change of the stub.

#include <Python.h>

#include <cstdlib>
#include <cstring>
#include <string>

namespace flatland {
namespace {

struct Doc {
  const char* scope;  // a class, or "" for the module
  const char* name;   // in the scope, or "" for the scope itself
  const char* text;
};

constexpr Doc kDocs[] = {
#include "core_docs.inc"
};

/// Sets a docstring. Returns false, with Python's error set, if that fails.
bool SetDoc(PyObject* object, const char* text) {
  if (PyInstanceMethod_Check(object)) object = PyInstanceMethod_GET_FUNCTION(object);
  if (PyCFunction_Check(object)) {
    PyMethodDef* const method = reinterpret_cast<PyCFunctionObject*>(object)->m_ml;
    std::free(const_cast<char*>(method->ml_doc));  // as pybind11 does when the function ends
    method->ml_doc = strdup(text);
    return true;
  }
  if (Py_TYPE(object) == &PyMethodDescr_Type) {
    std::string bound = text;  // "$self" is left out in the signature of a bound method
    bound.insert(bound.find('(') + 1, "$");
    reinterpret_cast<PyMethodDescrObject*>(object)->d_method->ml_doc = strdup(bound.c_str());
    return true;
  }
  PyObject* const doc = PyUnicode_FromString(text);
  const bool is_set = doc != nullptr && PyObject_SetAttrString(object, "__doc__", doc) == 0;
  Py_XDECREF(doc);
  return is_set;
}

bool SetDocIn(PyObject* scope, const Doc& doc) {
  if (*doc.name == '\0') return SetDoc(scope, doc.text);
  // Not by getattr, which makes bound methods.
  PyObject* const members = PyType_Check(scope) ? reinterpret_cast<PyTypeObject*>(scope)->tp_dict
                                                : PyModule_GetDict(scope);
  PyObject* const object = PyDict_GetItemString(members, doc.name);
  if (object != nullptr) return SetDoc(object, doc.text);
  PyErr_Format(PyExc_ImportError, "_core.pyi: there is no %s.%s", doc.scope, doc.name);
  return false;
}

}  // namespace

bool SetDocs(PyObject* module) {
  for (const Doc& doc : kDocs) {
    const bool is_of_module = *doc.scope == '\0';
    PyObject* const scope = is_of_module ? module : PyObject_GetAttrString(module, doc.scope);
    const bool is_set = scope != nullptr && SetDocIn(scope, doc);
    if (!is_of_module) Py_XDECREF(scope);
    if (!is_set) return false;
  }
  return true;
}

}  // namespace flatland
