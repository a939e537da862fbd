#include "module.h"

namespace etendue::python {
namespace {

const char* name_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::usage:
      return "usage";
    case ErrorKind::scene:
      return "scene";
    case ErrorKind::device:
      return "device";
    case ErrorKind::lost:
      return "lost";
    case ErrorKind::file:
      return "file";
    case ErrorKind::comparison:
      return "comparison";
    case ErrorKind::interrupted:
      return "interrupted";
    case ErrorKind::bug:
      break;
  }
  return "bug";
}

/// Makes the exception of etendue._errors that belongs to a kind and raises it.
void raise(const Error& error, const std::vector<Diagnostic>& findings) {
  const nb::object exception = nb::module_::import_("etendue._errors")
                                   .attr("error_of")(name_of(error.kind()), error.what(), findings_of(findings));
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(exception.ptr())), exception.ptr());
}

const Diagnostic& first_error(const std::vector<Diagnostic>& findings) {
  for (const Diagnostic& finding : findings) {
    if (finding.severity == Severity::error) return finding;
  }
  return findings.front();
}

}  // namespace

ReadFailure::ReadFailure(std::vector<Diagnostic> findings)
    : Error(first_error(findings).kind, to_string(first_error(findings))), findings_(std::move(findings)) {}

std::vector<Finding> findings_of(const std::vector<Diagnostic>& diagnostics) {
  std::vector<Finding> findings;
  for (const auto& [severity, position, message, kind] : diagnostics)
    findings.emplace_back(to_string(severity), message, position.file, position.line, position.column);
  return findings;
}

void bind_errors(nb::module_&) {
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const ReadFailure& failure) {
      raise(failure, failure.findings());
    } catch (const Error& error) {
      raise(error, {});
    }
  });
}

}  // namespace etendue::python
