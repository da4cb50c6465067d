// SPDX-License-Identifier: Apache-2.0
#include "core/error.h"
#include "io/mesh/mesh_formats.h"

#ifdef SIMPLEXSEG_HAS_LIB3MF

#include <Model/COM/NMR_DLLInterfaces.h>

#include <array>
#include <vector>

#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

/// Object of the library, released with this.
class Handle {
 public:
  Handle() = default;
  ~Handle() {
    if (object_) NMR::lib3mf_release(object_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  NMR::PLib3MFBase* get() const { return object_; }
  NMR::PLib3MFBase** receive() { return &object_; }
  /// Throws Error for a result that is a failure of this object.
  void check(LIB3MFRESULT result) const {
    if (result == LIB3MF_OK) return;
    DWORD code = 0;
    LPCSTR message = nullptr;
    if (object_) NMR::lib3mf_getlasterror(object_, &code, &message);
    throw Error("cannot write 3MF", message ? message : "the 3MF library failed", "write another format");
  }

 private:
  NMR::PLib3MFBase* object_ = nullptr;
};

void add(const Handle& model, const NamedSurface& surface) {
  const TriangleMesh triangles = tessellate(*surface.mesh);
  std::vector<NMR::MODELMESHVERTEX> vertices(triangles.positions.size());
  for (std::size_t v = 0; v < vertices.size(); ++v)
    for (int a = 0; a < 3; ++a) vertices[v].m_fPosition[a] = triangles.positions[v][a];
  std::vector<NMR::MODELMESHTRIANGLE> corners(triangles.triangles.size());
  for (std::size_t t = 0; t < corners.size(); ++t)
    for (std::size_t a = 0; a < 3; ++a) corners[t].m_nIndices[a] = static_cast<DWORD>(triangles.triangles[t][a]);
  Handle object, materials, properties, item;
  model.check(NMR::lib3mf_model_addmeshobject(model.get(), object.receive()));
  object.check(NMR::lib3mf_object_setnameutf8(object.get(), surface.name.c_str()));
  object.check(NMR::lib3mf_meshobject_setgeometry(object.get(), vertices.data(), static_cast<DWORD>(vertices.size()),
                                                  corners.data(), static_cast<DWORD>(corners.size())));
  DWORD group = 0, index = 0;
  model.check(NMR::lib3mf_model_addbasematerialgroup(model.get(), materials.receive()));
  materials.check(NMR::lib3mf_basematerial_getresourceid(materials.get(), &group));
  const Colour& c = surface.colour;
  materials.check(
      NMR::lib3mf_basematerial_addmaterialutf8(materials.get(), surface.name.c_str(), c.red, c.green, c.blue, &index));
  object.check(NMR::lib3mf_object_createdefaultpropertyhandler(object.get(), properties.receive()));
  properties.check(NMR::lib3mf_defaultpropertyhandler_setbasematerial(properties.get(), group, index));
  model.check(NMR::lib3mf_model_addbuilditem(model.get(), object.get(), nullptr, item.receive()));
}

}  // namespace

void require_three_mf() {}

std::string three_mf_of(std::span<const NamedSurface> surfaces) {
  Handle model, writer;
  if (NMR::lib3mf_createmodel(model.receive()) != LIB3MF_OK)
    throw Error("cannot write 3MF", "the 3MF library failed", "write another format");
  model.check(NMR::lib3mf_model_setunit(model.get(), NMR::MODELUNIT_MILLIMETER));
  const std::pair<const char*, std::string> texts[] = {{"Application", "SimplexSeg " SIMPLEXSEG_VERSION},
                                                       {"Description", std::string("Surfaces, ") + mesh_frame}};
  for (const auto& [key, text] : texts) model.check(NMR::lib3mf_model_addmetadatautf8(model.get(), key, text.c_str()));
  for (const NamedSurface& surface : surfaces) add(model, surface);
  model.check(NMR::lib3mf_model_querywriter(model.get(), "3mf", writer.receive()));
  ULONG64 size = 0;
  writer.check(NMR::lib3mf_writer_getstreamsize(writer.get(), &size));
  std::string bytes(size, '\0');
  writer.check(NMR::lib3mf_writer_writetobuffer(writer.get(), reinterpret_cast<BYTE*>(bytes.data()), size));
  return bytes;
}

}  // namespace simplexseg

#else

namespace simplexseg {

void require_three_mf() {
  throw Error("cannot write 3MF", "this program was built without lib3mf", "build it with lib3mf-dev, or write .glb");
}

std::string three_mf_of(std::span<const NamedSurface>) {
  require_three_mf();
  return {};
}

}  // namespace simplexseg

#endif
