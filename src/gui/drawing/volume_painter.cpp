// SPDX-License-Identifier: Apache-2.0
#include "gui/drawing/volume_painter.h"

#include <GL/glew.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/expect.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMostTexels = std::size_t{64} << 20, kMostReducedTexels = std::size_t{8} << 20;
constexpr int kMostReducedRays = 40'000;
constexpr float kModeShaded = 0, kModeMaximum = 1, kModeMaximumAndDepth = 2;  // of volume.frag
constexpr float kSpacing = 0.4f, kReducedSpacing = 0.75f;                     // distance of samples, texels

unsigned create_texture(GLenum format, const Eigen::Vector2i& size_px) {
  unsigned texture = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &texture);
  glTextureStorage2D(texture, 1, format, size_px.x(), size_px.y());
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(texture, filter, GL_NEAREST);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) glTextureParameteri(texture, axis, GL_CLAMP_TO_EDGE);
  return texture;
}

int current_frame() {
  int frame = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &frame);
  return frame;
}

}  // namespace

void VolumePainter::create() {
  rays_.create("cover.vert", "volume.frag");
  enlarge_.create("cover.vert", "volume_reduced.frag");
  glCreateVertexArrays(1, &vertex_array_);
}

void VolumePainter::destroy() {
  release();
  rays_.destroy();
  enlarge_.destroy();
  glDeleteVertexArrays(1, &vertex_array_);
  vertex_array_ = 0;
}

void VolumePainter::release() {
  texture_.release();
  release_images();
}

void VolumePainter::release_images() {
  for (Image* image : {&far_, &near_, &maxima_}) {
    glDeleteFramebuffers(1, &image->frame);
    glDeleteTextures(1, &image->texture);
    *image = {};
  }
  size_px_ = reduced_px_ = {0, 0};
  shown_volume_ = nullptr;
}

std::size_t VolumePainter::bytes() const {
  const auto pixels = [](const Eigen::Vector2i& size) { return static_cast<std::size_t>(size.prod()); };
  return texture_.bytes() + (far_.texture ? 8 * pixels(size_px_) : 0) + (maxima_.texture ? 8 * pixels(reduced_px_) : 0);
}

void VolumePainter::allocate(const Eigen::Vector2i& size_px) {
  if (size_px == size_px_ && (maxima_.texture != 0) == reduced_) return;
  release_images();
  size_px_ = size_px;
  for (Image* image : {&far_, &near_}) {
    // The format of the frame buffers of Qt: only equal formats can be copied.
    image->texture = create_texture(GL_DEPTH24_STENCIL8, size_px);
    glCreateFramebuffers(1, &image->frame);
    glNamedFramebufferTexture(image->frame, GL_DEPTH_STENCIL_ATTACHMENT, image->texture, 0);
    glNamedFramebufferDrawBuffer(image->frame, GL_NONE);
    glNamedFramebufferReadBuffer(image->frame, GL_NONE);
  }
  if (!reduced_) return;
  int divisor = 3;
  while (size_px.prod() / (divisor * divisor) > kMostReducedRays) ++divisor;
  reduced_px_ = ((size_px.array() + divisor - 1) / divisor).max(1);
  maxima_.texture = create_texture(GL_RG32F, reduced_px_);
  glCreateFramebuffers(1, &maxima_.frame);
  glNamedFramebufferTexture(maxima_.frame, GL_COLOR_ATTACHMENT0, maxima_.texture, 0);
}

void VolumePainter::update(const Projection& projection, const Volume& volume, const ViewState& view, CutEquations cut,
                           bool reduced) {
  SIMPLEXSEG_EXPECT(view.volume_mode != VolumeMode::Off && (!reduced || view.volume_mode == VolumeMode::Maximum));
  reduced_ = reduced;
  const BlockValue value = view.volume_mode == VolumeMode::Maximum ? BlockValue::Maximum : BlockValue::Mean;
  texture_.update(volume, value, reduced ? kMostReducedTexels : kMostTexels);
  allocate(projection.viewport_px.cast<int>());
  set_window(view);
  if (!reduced_) {
    set_rays(projection, cut);
    rays_.set("mode", view.volume_mode == VolumeMode::Maximum ? kModeMaximum : kModeShaded);
    return;
  }
  const Camera camera{projection.clip_from_world, {cut.begin(), cut.end()}};
  if (shown_volume_ == volume.data() && shown_ == camera) return;
  set_rays(projection, cut);
  cast_reduced(projection);
  shown_ = camera;
  shown_volume_ = volume.data();
}

void VolumePainter::set_rays(const Projection& projection, CutEquations cut) const {
  const Eigen::Matrix4d texture_from_world = texture_.texture_from_world(),
                        world_from_texture = texture_from_world.inverse(),
                        clip_from_texture = projection.clip_from_world.cast<double>() * world_from_texture;
  rays_.set("clip_from_texture", Eigen::Matrix4f(clip_from_texture.cast<float>()));
  rays_.set("texture_from_clip", Eigen::Matrix4f(clip_from_texture.inverse().cast<float>()));
  rays_.set("world_from_texture", Eigen::Matrix4f(world_from_texture.cast<float>()));
  const Eigen::Vector3d size(texture_.size()[0], texture_.size()[1], texture_.size()[2]);
  // Gradients transform by the transposed inverse of the transformation of positions.
  Eigen::Matrix4d eye_from_gradient = Eigen::Matrix4d::Identity();
  eye_from_gradient.topLeftCorner<3, 3>() = projection.eye_from_world.topLeftCorner<3, 3>().cast<double>() *
                                            texture_from_world.topLeftCorner<3, 3>().transpose() * size.asDiagonal();
  rays_.set("eye_from_gradient", Eigen::Matrix4f(eye_from_gradient.cast<float>()));
  const Eigen::Vector3d extent = texture_.extent();
  rays_.set("extent", Eigen::Vector3f(extent.cast<float>()));
  std::vector<Eigen::Vector4f> planes(kCutPlanes, Eigen::Vector4f::Zero());
  for (std::size_t n = 0; n < cut.size(); ++n)
    planes[n] = (world_from_texture.transpose() * cut[n].cast<double>()).cast<float>();
  rays_.set("cut", std::span<const Eigen::Vector4f>(planes));
  // A layer of white voxels of 0.25% of the diagonal of the volume is nearly opaque.
  const double diagonal_mm = (world_from_texture.topLeftCorner<3, 3>() * extent).norm();
  rays_.set("density", static_cast<float>(1200 / diagonal_mm));
  rays_.set("spacing", reduced_ ? kReducedSpacing : kSpacing);
}

void VolumePainter::set_window(const ViewState& view) const {
  for (const Program* program : {&rays_, &enlarge_}) {
    program->set("low", static_cast<float>(texture_.texel_value(view.level - view.window / 2)));
    program->set("high", static_cast<float>(texture_.texel_value(view.level + view.window / 2)));
    program->set("inverted", view.low_is_bright ? 1.0f : 0.0f);
    program->set("viewport_px", Eigen::Vector2f(size_px_.cast<float>()));
  }
}

void VolumePainter::cast_reduced(const Projection& projection) const {
  const int frame = current_frame();
  rays_.set("mode", kModeMaximumAndDepth);
  rays_.set("viewport_px", Eigen::Vector2f(reduced_px_.cast<float>()));
  rays_.set("ends_at_depth", 0.0f);
  rays_.set("begins_at_depth", 0.0f);
  rays_.use();
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, maxima_.frame);
  glViewport(0, 0, reduced_px_.x(), reduced_px_.y());
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glBindTextureUnit(0, texture_.name());
  glBindVertexArray(vertex_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glViewport(0, 0, static_cast<int>(projection.viewport_px.x()), static_cast<int>(projection.viewport_px.y()));
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<unsigned>(frame));
}

void VolumePainter::take_depth() {
  has_near_ = false;
  const auto frame = static_cast<unsigned>(current_frame());
  const int width = size_px_.x(), height = size_px_.y();
  glBlitNamedFramebuffer(frame, far_.frame, 0, 0, width, height, 0, 0, width, height, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
}

int VolumePainter::begin_near_depth() {
  const int frame = current_frame();
  const int width = size_px_.x(), height = size_px_.y();
  glStencilMask(~0u);
  glBlitNamedFramebuffer(far_.frame, near_.frame, 0, 0, width, height, 0, 0, width, height, GL_DEPTH_BUFFER_BIT,
                         GL_NEAREST);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, near_.frame);
  glClear(GL_STENCIL_BUFFER_BIT);
  glStencilMask(1);  // as in begin_frame()
  return frame;
}

void VolumePainter::end_near_depth(int frame) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<unsigned>(frame));
  has_near_ = true;
}

void VolumePainter::draw(Part part) const {
  SIMPLEXSEG_EXPECT(part == Part::InFront || has_near_);
  const bool in_front = part == Part::InFront;
  const Program& program = reduced_ ? enlarge_ : rays_;
  program.set("ends_at_depth", 1.0f);
  program.set("begins_at_depth", in_front ? 0.0f : 1.0f);
  program.use();
  glBindTextureUnit(0, reduced_ ? maxima_.texture : texture_.name());
  glBindTextureUnit(1, in_front && has_near_ ? near_.texture : far_.texture);
  glBindTextureUnit(2, near_.texture);
  glBindVertexArray(vertex_array_);
  glDisable(GL_DEPTH_TEST);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
  for (unsigned unit = 0; unit < 3; ++unit) glBindTextureUnit(unit, 0);
}

}  // namespace simplexseg
