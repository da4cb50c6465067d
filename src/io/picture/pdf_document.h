// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/picture/picture_io.h"

namespace simplexseg {

/// A4 document that is filled from the top, page after page. All texts are UTF-8.
class PdfDocument {
 public:
  /// `title`: first line, and title of the file; `footer`: at the foot of each page, beside the number of the page.
  PdfDocument(const std::string& title, std::string footer);
  ~PdfDocument();
  PdfDocument(const PdfDocument&) = delete;
  PdfDocument& operator=(const PdfDocument&) = delete;

  void add_heading(const std::string& text);
  /// Text that is broken into lines between words; `emphasised`: bold.
  void add_paragraph(const std::string& text, bool emphasised = false);
  /// Rows of cells; the first contains the headings, which each page repeats. Columns from index `first_right` on are
  /// right-aligned. Long cells are shortened with an ellipsis.
  void add_table(const std::vector<std::vector<std::string>>& rows, std::size_t first_right);
  /// Names and values in two columns; long values are broken into lines.
  void add_facts(const std::vector<std::pair<std::string, std::string>>& facts);
  /// Picture as wide as the text, with a heading above and a caption below, which stay on its page.
  void add_picture(const std::string& heading, const Picture& picture, const std::string& caption);

  /// Completes the document and returns the bytes of the file. Throws Error if cairo rejected something.
  std::string finish();

 private:
  class Page;
  std::unique_ptr<Page> page_;
};

}  // namespace simplexseg
