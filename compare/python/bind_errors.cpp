#include <exception>
#include <filesystem>
#include <stdexcept>

#include "analytic/catalogue/model_plugin.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/python/bindings.h"
#include "phase/parameters/one_line.h"
#include "volume/walk/walk.h"

namespace lamella {
namespace {

// One line, as the command line prints it.
void set_error(PyObject* type, const std::exception& error) {
  PyErr_SetString(type, one_line(error.what(), 1 << 14).c_str());
}

}  // namespace

// The command line's statuses as exceptions: 2 (bad input) is ValueError, files that cannot be
// written or read OSError, 3 (numbers that are not finite) ArithmeticError; the texts are the same.
void bind_errors(pybind11::module_&) {
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const NonFiniteError& error) {
      set_error(PyExc_ArithmeticError, error);
    } catch (const std::domain_error& error) {
      set_error(PyExc_ArithmeticError, error);
    } catch (const OutputError& error) {
      set_error(PyExc_OSError, error);
    } catch (const FolderInUse& error) {
      set_error(PyExc_OSError, error);
    } catch (const std::filesystem::filesystem_error& error) {
      set_error(PyExc_OSError, error);
    } catch (const pybind11::builtin_exception&) {
      throw;
    } catch (const std::invalid_argument& error) {
      set_error(PyExc_ValueError, error);
    } catch (const std::out_of_range& error) {
      set_error(PyExc_IndexError, error);
    } catch (const std::logic_error& error) {
      set_error(PyExc_RuntimeError, error);
    } catch (const std::runtime_error& error) {
      // UsageError, StackFileError, GridFileError, ...: what main turns into status 2.
      set_error(PyExc_ValueError, error);
    }
  });
}

}  // namespace lamella
