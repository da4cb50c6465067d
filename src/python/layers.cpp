// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <limits>

#include "io/platform/files.h"
#include "io/scene/layer_file.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "python/items.h"
#include "python/messages.h"

namespace simplexseg::python {
namespace {

/// Returns a copy of a layer of the scene.
LayerItem layer_of(const SceneLayer& layer) {
  return layer.session->use([&](const Session& session) {
    const LayerItem* const found = session.scene_without_poses().find_layer(layer.id);
    if (!found) throw Error("layer " + std::to_string(layer.id), "it is no longer in the scene", "use another layer");
    return *found;
  });
}

/// Returns a command that changes nothing yet. Not inlined: GCC 12 otherwise reports its optional members as
/// uninitialised.
[[gnu::noinline]] EditLayer edit_of(const SceneLayer& layer) { return EditLayer{layer.id}; }

/// Returns a property of a layer that `member` names, and a function that sets it.
template <class T>
auto getter(T LayerItem::*member) {
  return [member](const SceneLayer& layer) { return layer_of(layer).*member; };
}
template <class T>
auto setter(std::optional<T> EditLayer::*member) {
  return [member](const SceneLayer& layer, const T& value) {
    EditLayer edit = edit_of(layer);
    edit.*member = value;
    apply(*layer.session, edit);
  };
}

void set_affine(const SceneLayer& layer, const py::object& matrix) {
  EditLayer edit = edit_of(layer);
  edit.transform = layer_of(layer).transform;
  edit.transform->affine.matrix() = matrix_of(matrix, 4, 4, "affine");
  apply(*layer.session, edit);
}

/// Files of a layer; reads those that are not loaded. Issues warnings, and throws Error if the image cannot be read.
LayerImages images_of(const SceneLayer& layer) {
  Scene scene;
  scene.layers = {layer_of(layer)};
  LayerImages& images = layer.session->layer_images();
  std::vector<std::string> warnings;
  interruptible([&] {
    images.load(scene, std::filesystem::path(layer.session->scene_path()).parent_path(), warnings);
    return 0;
  });
  if (!images.image_of(scene.layers[0]) || !images.has_transform(scene.layers[0]))
    throw Error(warnings.empty() ? "the layer is not loaded" : warnings.front());
  warn(warnings);
  return images;
}

py::array_t<double> values_at(const SceneLayer& layer, const py::object& points) {
  const LayerImages images = images_of(layer);
  const LayerItem item = layer_of(layer);
  const py::array_t<double> positions = map_points(Eigen::Affine3d::Identity(), points, "points");
  std::vector<py::ssize_t> shape(positions.shape(), positions.shape() + positions.ndim() - 1);
  py::array_t<double> values(shape);
  const double* const from = positions.data();
  double* const to = values.mutable_data();
  for (py::ssize_t n = 0; n < positions.size() / 3; ++n)
    to[n] = images.value_at(item, {from[3 * n], from[3 * n + 1], from[3 * n + 2]})
                .value_or(std::numeric_limits<double>::quiet_NaN());
  return values;
}

}  // namespace

std::vector<SceneLayer> layers_of(const std::shared_ptr<SessionOwner>& session) {
  return session->use([&](const Session& s) {
    std::vector<SceneLayer> layers;
    for (const LayerItem& item : s.scene_without_poses().layers) layers.push_back({{session, item.id}});
    return layers;
  });
}

SceneLayer add_layer(const std::shared_ptr<SessionOwner>& session, const std::filesystem::path& path,
                     const std::string& name, const std::optional<std::filesystem::path>& transform) {
  LayerImages images;
  LayerFile layer = interruptible([&] {
    LayerFile read = read_layer(path);
    images.add_image(read.item, read.image);
    if (!transform) return read;
    Transform loaded;
    read.item.transform = load_layer_transform(*transform, loaded);
    images.add_transform(read.item.transform, std::move(loaded));
    return read;
  });
  if (!name.empty()) layer.item.name = name;
  warn(layer.warnings);
  session->layer_images().add(images);
  return {{session, apply(*session, AddLayer{layer.item})}};
}

void bind_layers(py::module_& module) {
  py::class_<SceneLayer>(module, "SceneLayer",
                         "A further image of the scene of a session, shown over its volume. Raises Error like "
                         "SceneMesh.")
      .def("__eq__",
           [](const SceneLayer& one, const py::object& other) {
             return py::isinstance<SceneLayer>(other) && one == other.cast<const SceneLayer&>();
           })
      .def("__hash__", [](const SceneLayer& one) { return std::hash<const void*>()(one.session.get()) ^ one.id; })
      .def_property_readonly(
          "id", [](const SceneLayer& one) { return one.id; }, "Unique in a session, also in its logs.")
      .def_property("name", getter(&LayerItem::name), setter(&EditLayer::name), "Name in the window.")
      .def_property_readonly(
          "path", [](const SceneLayer& one) { return std::filesystem::path(layer_of(one).path); }, "File of the image.")
      .def_property_readonly("unit", getter(&LayerItem::unit), "Unit of the values; \"\" if it is unknown.")
      .def_property("visible", getter(&LayerItem::visible), setter(&EditLayer::visible), "Whether it is shown.")
      .def_property("opacity", getter(&LayerItem::opacity), setter(&EditLayer::opacity), "Opacity of a blend, 0 to 1.")
      .def_property("window", getter(&LayerItem::window), setter(&EditLayer::window),
                    "Difference of the values with the first and the last colour.")
      .def_property("level", getter(&LayerItem::level), setter(&EditLayer::level),
                    "Value with the colour in the middle.")
      .def_property(
          "affine",
          [](const SceneLayer& one) {
            const Eigen::Matrix4d matrix = layer_of(one).transform.affine.matrix();
            return array_of(matrix);
          },
          &set_affine,
          "Affine map (4 x 4) from points of the volume to points of the layer, mm, LPS. A displacement field of the\n"
          "layer acts before it.")
      .def_property_readonly(
          "filters", [](const SceneLayer& one) { return describe(layer_of(one).preprocessing.filters); },
          "Description of the filters of the image; \"\" if there are none.")
      .def("values_at", &values_at, py::arg("points"),
           "Returns the values at points (..., 3) of the volume, mm, LPS, interpolated linearly; NaN outside the "
           "layer.\n"
           "Reads the files of the layer, and applies its filters, at the first call. Raises Error if that fails.")
      .def(
          "remove", [](const SceneLayer& one) { apply(*one.session, RemoveLayer{one.id}); }, "Removes the layer.");
}

}  // namespace simplexseg::python
