#include "module.h"

NB_MODULE(_core, m) {
  using namespace etendue::python;
  m.doc() = "The compiled part of etendue; etendue itself is what to import.";
  m.attr("version") = etendue::version();
  bind_errors(m);
  bind_pictures(m);
  bind_scenes(m);
  bind_objects(m);
  bind_parameters(m);
  bind_renders(m);
  bind_verdicts(m);
}
