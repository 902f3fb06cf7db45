// Arrays of numpy: what comes in is checked, what goes out is a view where there is one.
#ifndef CAIRN_PYTHON_ARRAYS_H_
#define CAIRN_PYTHON_ARRAYS_H_

#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/rigid3.h"
#include "python/errors.h"

namespace cairn::python {

// Returns `value` if it is an array whose elements lie one after the other, row by row, in the byte
// order of this machine. Throws Error(kInvalidArgument), which names the argument, otherwise.
py::array RequireArray(const std::string& argument, py::handle value);

// E.g. "float32 of shape (10, 3)".
std::string DescribeArray(const py::array& array);

template <typename T>
bool HoldsA(const py::array& array) {
  return py::dtype::of<T>().is(array.dtype()) || array.dtype().equal(py::dtype::of<T>());
}

// The elements of a one-dimensional array of T of any length, or of `length` elements if that is
// not negative. Throws as RequireArray.
template <typename T>
std::vector<T> ColumnOf(const std::string& argument, py::handle value, py::ssize_t length = -1) {
  const py::array array = RequireArray(argument, value);
  if (!HoldsA<T>(array) || array.ndim() != 1 || (length >= 0 && array.shape(0) != length)) {
    RefuseArgument(argument, DescribeArray(array) + "; must be " +
                                 py::str(py::dtype::of<T>()).cast<std::string>() + " of shape (" +
                                 (length >= 0 ? std::to_string(length) : std::string("N")) + ",)");
  }
  const T* data = static_cast<const T*>(array.data());
  return {data, data + array.shape(0)};
}

// The elements of an N x `num_columns` array of float64. Throws as RequireArray. `num_rows` as
// `length` of ColumnOf.
std::vector<double> RowsOf(const std::string& argument, py::handle value, py::ssize_t num_columns,
                           py::ssize_t num_rows = -1);

// A view, which cannot be written to, of elements that `owner` keeps alive.
template <typename T>
py::array_t<T> ViewOf(const T* data, std::vector<py::ssize_t> shape, py::handle owner) {
  py::array_t<T> view(std::move(shape), data, owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

// A new array, row by row.
py::array_t<double> ArrayOf(const Eigen::Ref<const Eigen::MatrixXd>& matrix);
py::array_t<double> VectorArrayOf(const Eigen::Vector3d& vector);
// The 4 x 4 matrix of a transform.
py::array_t<double> PoseArray(const Rigid3d& pose);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_ARRAYS_H_
