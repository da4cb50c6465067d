// SPDX-License-Identifier: Apache-2.0
#include "gui/painters.h"

#include <GL/glew.h>

#include <QFile>

#include "core/error.h"
#include "gui/slice_sampler.h"
#include "gui/surfaces.h"

static void make_shaders_known() { Q_INIT_RESOURCE(shaders); }

namespace simplexseg {

Rgba rgba_of(const Colour& colour, float alpha) {
  return {colour.red / 255.0f, colour.green / 255.0f, colour.blue / 255.0f, alpha};
}

void load_gl() {
  glewExperimental = GL_TRUE;
  const GLenum result = glewInit();
  // Without a GLX display (EGL, Wayland) GLEW loads OpenGL itself and then complains of GLX alone.
  if (result != GLEW_OK && result != GLEW_ERROR_NO_GLX_DISPLAY) {
    throw Error("OpenGL", reinterpret_cast<const char*>(glewGetErrorString(result)),
                "update the graphics driver, or use simplexseg-cli, which works without OpenGL");
  }
  make_shaders_known();
}

std::string gl_renderer() {
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return name ? name : "unknown renderer";
}

void begin_frame(const Projection& projection, const Rgba& background) {
  glViewport(0, 0, static_cast<int>(projection.viewport_px.x()), static_cast<int>(projection.viewport_px.y()));
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_CULL_FACE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LEQUAL);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  // The window must stay opaque: alpha is never lowered.
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glClearColor(background.x(), background.y(), background.z(), 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
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
  if (!file.open(QIODevice::ReadOnly)) throw Error("shader " + name, "not in the program", "build the program anew");
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

void Program::create(const char* name) {
  const unsigned vertex = compile(GL_VERTEX_SHADER, std::string(name) + ".vert");
  const unsigned fragment = compile(GL_FRAGMENT_SHADER, std::string(name) + ".frag");
  program_ = glCreateProgram();
  glAttachShader(program_, vertex);
  glAttachShader(program_, fragment);
  glLinkProgram(program_);
  glDeleteShader(vertex);
  glDeleteShader(fragment);
  int ok = 0;
  glGetProgramiv(program_, GL_LINK_STATUS, &ok);
  if (!ok) throw Error(std::string("shader ") + name, "it does not link", "update the graphics driver");
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

void SlicePainter::create() {
  program_.create("slice");
  glCreateVertexArrays(1, &vertex_array_);
}

void SlicePainter::destroy() {
  program_.destroy();
  glDeleteTextures(1, &texture_);
  glDeleteVertexArrays(1, &vertex_array_);
  texture_ = vertex_array_ = 0;
}

void SlicePainter::update(const SliceImage& image) {
  if (image.stamp == 0 || image.stamp == stamp_) return;
  const SliceGrid& grid = image.grid;
  if (texture_ == 0 || width_ != grid.width || height_ != grid.height) {
    glDeleteTextures(1, &texture_);
    glCreateTextures(GL_TEXTURE_2D, 1, &texture_);
    glTextureStorage2D(texture_, 1, GL_R32F, grid.width, grid.height);
    glTextureParameteri(texture_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(texture_, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(texture_, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture_, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    width_ = grid.width;
    height_ = grid.height;
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glTextureSubImage2D(texture_, 0, 0, 0, grid.width, grid.height, GL_RED, GL_FLOAT, image.intensities.data());
  stamp_ = image.stamp;
}

void SlicePainter::draw(const Projection& projection, const SliceImage& image, float low, float high,
                        bool show_black) const {
  if (texture_ == 0) return;
  const SliceGrid& grid = image.grid;
  program_.set("clip_from_world", projection.clip_from_world);
  const Eigen::Vector3d corner = grid.origin_mm - 0.5 * (grid.step_u_mm + grid.step_v_mm);
  program_.set("corner", Eigen::Vector3f(corner.cast<float>()));
  program_.set("edge_u", Eigen::Vector3f((grid.step_u_mm * grid.width).cast<float>()));
  program_.set("edge_v", Eigen::Vector3f((grid.step_v_mm * grid.height).cast<float>()));
  program_.set("low", low);
  program_.set("high", high);
  program_.set("darkest_shown", show_black ? -1.0f : 0.03f);
  program_.use();
  glBindTextureUnit(0, texture_);
  glBindVertexArray(vertex_array_);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

void LinePainter::create() {
  program_.create("line");
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
  if (ends_mm.size() < 2) return;
  glNamedBufferData(buffer_, static_cast<GLsizeiptr>(ends_mm.size_bytes()), ends_mm.data(), GL_STREAM_DRAW);
  program_.set("clip_from_world", projection.clip_from_world);
  program_.set("viewport_px", projection.viewport_px);
  program_.set("half_width_px", width_px / 2);
  program_.set("line_colour", colour);
  program_.use();
  glBindVertexArray(vertex_array_);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<int>(ends_mm.size() / 2));
}

void DiscPainter::create() {
  program_.create("disc");
  glCreateVertexArrays(1, &vertex_array_);
  glCreateBuffers(1, &buffer_);
  glVertexArrayVertexBuffer(vertex_array_, 0, buffer_, 0, 12 * sizeof(float));
  glVertexArrayBindingDivisor(vertex_array_, 0, 1);
  const int components[] = {3, 4, 4, 1};
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
  packed.reserve(discs.size() * 12);
  for (const Disc& disc : discs) {
    packed.insert(packed.end(), disc.centre_mm.data(), disc.centre_mm.data() + 3);
    packed.insert(packed.end(), disc.fill.data(), disc.fill.data() + 4);
    packed.insert(packed.end(), disc.rim.data(), disc.rim.data() + 4);
    packed.push_back(disc.radius_px);
  }
  glNamedBufferData(buffer_, static_cast<GLsizeiptr>(packed.size() * sizeof(float)), packed.data(), GL_STREAM_DRAW);
  program_.set("clip_from_world", projection.clip_from_world);
  program_.set("viewport_px", projection.viewport_px);
  program_.use();
  glBindVertexArray(vertex_array_);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<int>(discs.size()));
}

void MeshPainter::create() { program_.create("mesh"); }

void MeshPainter::release(Buffers& buffers) {
  glDeleteVertexArrays(1, &buffers.vertex_array);
  const unsigned names[] = {buffers.points, buffers.normals, buffers.indices};
  glDeleteBuffers(3, names);
  buffers = {};
}

void MeshPainter::destroy() {
  for (Buffers& buffers : buffers_) release(buffers);
  buffers_.clear();
  program_.destroy();
}

void MeshPainter::update(std::span<const Surface> surfaces) {
  for (std::size_t m = surfaces.size(); m < buffers_.size(); ++m) release(buffers_[m]);
  buffers_.resize(surfaces.size());
  for (std::size_t m = 0; m < surfaces.size(); ++m) {
    const Surface& surface = surfaces[m];
    Buffers& buffers = buffers_[m];
    if (buffers.vertex_array == 0) {
      glCreateVertexArrays(1, &buffers.vertex_array);
      unsigned names[3];
      glCreateBuffers(3, names);
      buffers.points = names[0];
      buffers.normals = names[1];
      buffers.indices = names[2];
      for (unsigned attribute = 0; attribute < 2; ++attribute) {
        glVertexArrayVertexBuffer(buffers.vertex_array, attribute, names[attribute], 0, sizeof(Eigen::Vector3f));
        glEnableVertexArrayAttrib(buffers.vertex_array, attribute);
        glVertexArrayAttribFormat(buffers.vertex_array, attribute, 3, GL_FLOAT, GL_FALSE, 0);
        glVertexArrayAttribBinding(buffers.vertex_array, attribute, attribute);
      }
      glVertexArrayElementBuffer(buffers.vertex_array, buffers.indices);
    }
    const auto bytes = static_cast<GLsizeiptr>(surface.points_mm.size() * sizeof(Eigen::Vector3f));
    if (buffers.topology_stamp != surface.topology_stamp) {
      glNamedBufferData(buffers.indices, static_cast<GLsizeiptr>(surface.triangles.size() * 3 * sizeof(int)),
                        surface.triangles.data(), GL_STATIC_DRAW);
      buffers.index_count = static_cast<int>(surface.triangles.size() * 3);
      buffers.topology_stamp = surface.topology_stamp;
    }
    glNamedBufferData(buffers.points, bytes, surface.points_mm.data(), GL_DYNAMIC_DRAW);
    glNamedBufferData(buffers.normals, bytes, surface.normals.data(), GL_DYNAMIC_DRAW);
  }
}

void MeshPainter::draw(const Projection& projection, int which, const Rgba& colour) {
  const Buffers& buffers = buffers_[which];
  program_.set("clip_from_world", projection.clip_from_world);
  program_.set("eye_from_world", projection.eye_from_world);
  program_.set("mesh_colour", colour);
  program_.use();
  glBindVertexArray(buffers.vertex_array);
  const auto draw_faces = [&](GLenum culled) {
    glEnable(GL_CULL_FACE);
    glCullFace(culled);
    glDrawElements(GL_TRIANGLES, buffers.index_count, GL_UNSIGNED_INT, nullptr);
    glDisable(GL_CULL_FACE);
  };
  if (colour.w() < 1) {
    glDepthMask(GL_FALSE);
    draw_faces(GL_FRONT);
    draw_faces(GL_BACK);
    glDepthMask(GL_TRUE);
  } else {
    glDrawElements(GL_TRIANGLES, buffers.index_count, GL_UNSIGNED_INT, nullptr);
  }
}

}  // namespace simplexseg
