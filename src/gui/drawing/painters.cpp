// SPDX-License-Identifier: Apache-2.0
#include "gui/drawing/painters.h"

#include <GL/glew.h>

#include <QColor>
#include <QFile>
#include <cstddef>

#include "core/error.h"
#include "core/expect.h"
#include "forces/step_view.h"

static void register_shaders() { Q_INIT_RESOURCE(shaders); }

namespace simplexseg {

Rgba rgba_of(const Colour& colour, float alpha) {
  return {colour.red / 255.0f, colour.green / 255.0f, colour.blue / 255.0f, alpha};
}

Rgba rgba_of(const QColor& colour, float alpha) {
  return {static_cast<float>(colour.redF()), static_cast<float>(colour.greenF()), static_cast<float>(colour.blueF()),
          alpha};
}

void load_gl() {
  glewExperimental = GL_TRUE;
  const GLenum result = glewInit();
  // Without a GLX display (EGL, Wayland), GLEW loads OpenGL; only the GLX part of GLEW fails.
  if (result != GLEW_OK && result != GLEW_ERROR_NO_GLX_DISPLAY) {
    throw Error("OpenGL", reinterpret_cast<const char*>(glewGetErrorString(result)),
                "update the graphics driver, or use simplexseg-cli, which needs no OpenGL");
  }
  register_shaders();
}

std::string gl_renderer() {
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return name ? name : "unknown renderer";
}

bool is_software_renderer() {
  static const bool software = [] {
    const std::string name = gl_renderer();
    return name.find("llvmpipe") != std::string::npos || name.find("softpipe") != std::string::npos ||
           name.find("swrast") != std::string::npos;
  }();
  return software;
}

void begin_frame(const Projection& projection, const Rgba& background) {
  glViewport(0, 0, static_cast<int>(projection.viewport_px.x()), static_cast<int>(projection.viewport_px.y()));
  // Multisampling smooths only edges, and takes a third of the time of a software renderer.
  if (is_software_renderer()) glDisable(GL_MULTISAMPLE);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_CULL_FACE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LEQUAL);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  // Alpha is never lowered: the window must stay opaque.
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glClearColor(background.x(), background.y(), background.z(), 1);
  glStencilMask(0xFF);  // the masks of CapPainter, too: a new frame buffer has any content
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  glStencilMask(1);
}

void set_depth(Depth depth) {
  if (depth == Depth::Test) {
    glEnable(GL_DEPTH_TEST);
  } else {
    glDisable(GL_DEPTH_TEST);
  }
}

void end_frame() {
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDepthMask(GL_TRUE);
  glBindVertexArray(0);
  glUseProgram(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glBindTextureUnit(0, 0);
  glActiveTexture(GL_TEXTURE0);
}

namespace {
unsigned compile(unsigned kind, const std::string& name) {
  QFile file(QString::fromStdString(":/shaders/" + name));
  if (!file.open(QIODevice::ReadOnly))
    throw Error("shader " + name, "it is missing in the program", "install the program again");
  const QByteArray source = file.readAll();
  const char* text = source.constData();
  const unsigned shader = glCreateShader(kind);
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  int ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (!ok) {
    char log[512] = "";
    glGetShaderInfoLog(shader, sizeof log, nullptr, log);
    glDeleteShader(shader);
    throw Error("shader " + name, std::string(log).substr(0, std::string(log).find('\n')),
                "update the graphics driver");
  }
  return shader;
}
}  // namespace

void Program::create(const char* vertex, const char* fragment) {
  program_ = glCreateProgram();
  const auto attach = [&](unsigned kind, const char* name) {
    const unsigned shader = compile(kind, name);
    glAttachShader(program_, shader);
    glDeleteShader(shader);
  };
  attach(GL_VERTEX_SHADER, vertex);
  attach(GL_FRAGMENT_SHADER, fragment);
  glLinkProgram(program_);
  int ok = 0;
  glGetProgramiv(program_, GL_LINK_STATUS, &ok);
  if (!ok) throw Error(std::string("shader ") + vertex, "it cannot be linked", "update the graphics driver");
}

void Program::destroy() {
  glDeleteProgram(program_);
  program_ = 0;
}

void Program::use() const { glUseProgram(program_); }
int Program::location(const char* uniform) const { return glGetUniformLocation(program_, uniform); }
void Program::set(const char* uniform, const Eigen::Matrix4f& value) const {
  glProgramUniformMatrix4fv(program_, location(uniform), 1, GL_FALSE, value.data());
}
void Program::set(const char* uniform, const Eigen::Vector4f& value) const {
  glProgramUniform4fv(program_, location(uniform), 1, value.data());
}
void Program::set(const char* uniform, const Eigen::Vector3f& value) const {
  glProgramUniform3fv(program_, location(uniform), 1, value.data());
}
void Program::set(const char* uniform, const Eigen::Vector2f& value) const {
  glProgramUniform2fv(program_, location(uniform), 1, value.data());
}
void Program::set(const char* uniform, float value) const { glProgramUniform1f(program_, location(uniform), value); }
void Program::set(const char* uniform, std::span<const Eigen::Vector4f> values) const {
  glProgramUniform4fv(program_, location(uniform), static_cast<int>(values.size()), values[0].data());
}

void SliceQuad::create(const char* vertex, const char* fragment) {
  program_.create(vertex, fragment);
  glCreateVertexArrays(1, &vertex_array_);
}

void SliceQuad::destroy() {
  program_.destroy();
  glDeleteVertexArrays(1, &vertex_array_);
  vertex_array_ = 0;
}

void SliceQuad::draw(const Projection& projection, const SliceGrid& slice, unsigned texture) const {
  program_.set("clip_from_world", projection.clip_from_world);
  program_.set("corner", Eigen::Vector3f(slice.corner_mm().cast<float>()));
  program_.set("edge_u", Eigen::Vector3f((slice.step_u_mm * slice.width).cast<float>()));
  program_.set("edge_v", Eigen::Vector3f((slice.step_v_mm * slice.height).cast<float>()));
  program_.use();
  glBindTextureUnit(0, texture);
  glBindVertexArray(vertex_array_);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

void SlicePainter::create() {
  quad_.create("slice.vert", "slice.frag");
  glCreateSamplers(1, &levels_);
  glSamplerParameteri(levels_, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glSamplerParameteri(levels_, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) glSamplerParameteri(levels_, axis, GL_CLAMP_TO_EDGE);
}

void SlicePainter::destroy() {
  quad_.destroy();
  glDeleteSamplers(1, &levels_);
  levels_ = 0;
}

void SlicePainter::draw(const Projection& projection, const SceneBuffers::Slice& slice, bool show_black,
                        CutEquations cut, const std::array<float, 2>& tinted, const Rgba& tint) const {
  const CutScope scope(quad_.program(), cut);
  quad_.program().set("tinted", Eigen::Vector2f(tinted[0], tinted[1]));
  quad_.program().set("tint", tint);
  quad_.program().set("darkest_shown", show_black ? -1.0f : 0.03f);
  quad_.program().set("mean_level", static_cast<float>(slice.mean_level));
  constexpr unsigned kMeans = 1;  // texture unit that slice.frag uses
  glBindTextureUnit(kMeans, slice.texture);
  glBindSampler(kMeans, levels_);
  quad_.draw(projection, slice.grid, slice.texture);
  glBindSampler(kMeans, 0);
  glBindTextureUnit(kMeans, 0);
}

void FieldPainter::draw(const Projection& projection, const SliceGrid& slice, const SceneBuffers::Field& field,
                        const Rgba& tint) const {
  const Program& program = quad_.program();
  program.set("index_from_world", Eigen::Matrix4f(field.index_from_world.cast<float>()));
  program.set("field_floor", kFieldFloor / kFieldScale);
  program.set("tint", tint);
  quad_.draw(projection, slice, field.texture);
}

void LinePainter::create() {
  program_.create("line.vert", "line.frag");
  glCreateVertexArrays(1, &vertex_array_);
  glCreateBuffers(1, &buffer_);
  glVertexArrayVertexBuffer(vertex_array_, 0, buffer_, 0, 2 * sizeof(Eigen::Vector3f));
  glVertexArrayBindingDivisor(vertex_array_, 0, 1);
  for (unsigned end = 0; end < 2; ++end) {
    glEnableVertexArrayAttrib(vertex_array_, end);
    glVertexArrayAttribFormat(vertex_array_, end, 3, GL_FLOAT, GL_FALSE, end * sizeof(Eigen::Vector3f));
    glVertexArrayAttribBinding(vertex_array_, end, 0);
  }
}

void LinePainter::destroy() {
  program_.destroy();
  glDeleteVertexArrays(1, &vertex_array_);
  glDeleteBuffers(1, &buffer_);
  vertex_array_ = buffer_ = 0;
}

void LinePainter::draw(const Projection& projection, std::span<const Eigen::Vector3f> ends_mm, const Rgba& colour,
                       float width_px) {
  SIMPLEXSEG_EXPECT(ends_mm.size() % 2 == 0);
  if (ends_mm.empty()) return;
  glNamedBufferData(buffer_, static_cast<GLsizeiptr>(ends_mm.size_bytes()), ends_mm.data(), GL_STREAM_DRAW);
  program_.set("clip_from_world", projection.clip_from_world);
  program_.set("viewport_px", projection.viewport_px);
  program_.set("half_width_px", width_px / 2);
  program_.set("line_colour", colour);
  program_.use();
  glBindVertexArray(vertex_array_);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<int>(ends_mm.size() / 2));
}

static constexpr int kFloatsPerDisc = 13;

void DiscPainter::create() {
  program_.create("disc.vert", "disc.frag");
  glCreateVertexArrays(1, &vertex_array_);
  glCreateBuffers(1, &buffer_);
  glVertexArrayVertexBuffer(vertex_array_, 0, buffer_, 0, kFloatsPerDisc * sizeof(float));
  glVertexArrayBindingDivisor(vertex_array_, 0, 1);
  const int components[] = {3, 4, 4, 2};
  unsigned offset = 0;
  for (unsigned attribute = 0; attribute < 4; ++attribute) {
    glEnableVertexArrayAttrib(vertex_array_, attribute);
    glVertexArrayAttribFormat(vertex_array_, attribute, components[attribute], GL_FLOAT, GL_FALSE, offset);
    glVertexArrayAttribBinding(vertex_array_, attribute, 0);
    offset += components[attribute] * sizeof(float);
  }
}

void DiscPainter::destroy() {
  program_.destroy();
  glDeleteVertexArrays(1, &vertex_array_);
  glDeleteBuffers(1, &buffer_);
  vertex_array_ = buffer_ = 0;
}

void DiscPainter::draw(const Projection& projection, std::span<const Disc> discs) {
  if (discs.empty()) return;
  std::vector<float> packed;
  packed.reserve(discs.size() * kFloatsPerDisc);
  for (const Disc& disc : discs) {
    packed.insert(packed.end(), disc.centre_mm.data(), disc.centre_mm.data() + 3);
    packed.insert(packed.end(), disc.fill.data(), disc.fill.data() + 4);
    packed.insert(packed.end(), disc.rim.data(), disc.rim.data() + 4);
    packed.push_back(disc.radius_px);
    packed.push_back(static_cast<float>(disc.glyph));
  }
  glNamedBufferData(buffer_, static_cast<GLsizeiptr>(packed.size() * sizeof(float)), packed.data(), GL_STREAM_DRAW);
  program_.set("clip_from_world", projection.clip_from_world);
  program_.set("viewport_px", projection.viewport_px);
  program_.use();
  glBindVertexArray(vertex_array_);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<int>(discs.size()));
}

void SurfaceArray::create() {
  glCreateVertexArrays(1, &vertex_array_);
  const unsigned offsets[] = {offsetof(DisplayPoint, position), offsetof(DisplayPoint, normal)};
  for (unsigned attribute = 0; attribute < 2; ++attribute) {
    glEnableVertexArrayAttrib(vertex_array_, attribute);
    glVertexArrayAttribFormat(vertex_array_, attribute, 3, GL_FLOAT, GL_FALSE, offsets[attribute]);
    glVertexArrayAttribBinding(vertex_array_, attribute, 0);
  }
  glVertexArrayAttribFormat(vertex_array_, 2, 1, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(vertex_array_, 2, 1);
}

void SurfaceArray::destroy() {
  glDeleteVertexArrays(1, &vertex_array_);
  vertex_array_ = 0;
}

// The buffers are recreated when meshes change; binding them for each frame is cheap.
void SurfaceArray::bind(const SceneBuffers& buffers, bool with_values) const {
  constexpr unsigned kValue = 2;
  if (with_values) {
    glEnableVertexArrayAttrib(vertex_array_, kValue);
    glVertexArrayVertexBuffer(vertex_array_, 1, buffers.values(), 0, sizeof(float));
  } else {
    glDisableVertexArrayAttrib(vertex_array_, kValue);
  }
  glVertexArrayVertexBuffer(vertex_array_, 0, buffers.points(), 0, sizeof(DisplayPoint));
  glVertexArrayElementBuffer(vertex_array_, buffers.indices());
  glBindVertexArray(vertex_array_);
}

void draw_mesh_triangles(const SceneBuffers& buffers, int mesh) {
  const SceneBuffers::Range& range = buffers.triangles(mesh);
  glDrawElements(GL_TRIANGLES, range.count, GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(range.first * sizeof(GLuint)));
}

void MeshPainter::create() {
  program_.create("mesh.vert", "mesh.frag");
  surfaces_.create();
}

void MeshPainter::destroy() {
  program_.destroy();
  surfaces_.destroy();
}

void MeshPainter::draw(const Projection& projection, const SceneBuffers& buffers, int mesh, const Rgba& colour,
                       float most_mm, CutEquations cut) const {
  const CutScope scope(program_, cut);
  program_.set("most_mm", most_mm);
  program_.set("clip_from_world", projection.clip_from_world);
  program_.set("eye_from_world", projection.eye_from_world);
  program_.set("mesh_colour", colour);
  program_.use();
  surfaces_.bind(buffers, most_mm > 0);
  const auto draw_faces = [&](GLenum culled) {
    glEnable(GL_CULL_FACE);
    glCullFace(culled);
    draw_mesh_triangles(buffers, mesh);
    glDisable(GL_CULL_FACE);
  };
  if (colour.w() < 1) {
    glDepthMask(GL_FALSE);
    draw_faces(GL_FRONT);
    draw_faces(GL_BACK);
    glDepthMask(GL_TRUE);
  } else {
    draw_faces(GL_BACK);  // back faces of a closed surface are hidden, but would double the cost
  }
}

void OutlinePainter::create() {
  program_.create("line.vert", "line.frag");
  count_.create("fill.vert", "fill.frag");
  cover_.create("cover.vert", "fill.frag");
  glCreateVertexArrays(1, &vertex_array_);
  glVertexArrayBindingDivisor(vertex_array_, 0, 1);
  for (unsigned end = 0; end < 2; ++end) {
    glEnableVertexArrayAttrib(vertex_array_, end);
    glVertexArrayAttribFormat(vertex_array_, end, 3, GL_FLOAT, GL_FALSE, end * sizeof(Vec3));
    glVertexArrayAttribBinding(vertex_array_, end, 0);
  }
}

void OutlinePainter::destroy() {
  for (Program* program : {&program_, &count_, &cover_}) program->destroy();
  glDeleteVertexArrays(1, &vertex_array_);
  vertex_array_ = 0;
}

void OutlinePainter::draw(const Projection& projection, const SceneBuffers::Outlines& outlines, int mesh,
                          const Rgba& colour, float width_px) const {
  if (outlines.buffer == 0) return;
  program_.set("clip_from_world", projection.clip_from_world);
  program_.set("viewport_px", projection.viewport_px);
  program_.set("half_width_px", width_px / 2);
  program_.set("line_colour", colour);
  program_.use();
  draw_segments(outlines, mesh);
}

void OutlinePainter::fill(const Projection& projection, const SceneBuffers::Outlines& outlines, int mesh,
                          const Rgba& colour) const {
  if (outlines.buffer == 0) return;
  count_.set("clip_from_world", projection.clip_from_world);
  count_.use();
  glEnable(GL_STENCIL_TEST);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glStencilMask(1);
  glStencilFunc(GL_ALWAYS, 0, 1);
  glStencilOp(GL_INVERT, GL_INVERT, GL_INVERT);
  draw_segments(outlines, mesh);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glStencilFunc(GL_EQUAL, 1, 1);
  glStencilOp(GL_KEEP, GL_ZERO, GL_ZERO);
  cover_.set("fill_colour", colour);
  cover_.use();
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_STENCIL_TEST);
}

void OutlinePainter::draw_segments(const SceneBuffers::Outlines& outlines, int mesh) const {
  glVertexArrayVertexBuffer(vertex_array_, 0, outlines.buffer, static_cast<GLintptr>(outlines.segments_at),
                            sizeof(OutlineSegment));
  glBindVertexArray(vertex_array_);
  // The number of segments is stored only in the buffer.
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, outlines.buffer);
  glDrawArraysIndirect(GL_TRIANGLE_STRIP, reinterpret_cast<const void*>(mesh * sizeof(OutlineCommand)));
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

}  // namespace simplexseg
