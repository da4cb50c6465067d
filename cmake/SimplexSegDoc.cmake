# The target doc: the reference of the headers in docs/api/, by Doxygen, which must have nothing to complain about. It is
# made on demand alone.
find_package(Doxygen QUIET)
if(DOXYGEN_FOUND)
  set(DOXYGEN_PROJECT_NUMBER ${PROJECT_VERSION})
  set(DOXYGEN_OUTPUT_DIRECTORY ${CMAKE_SOURCE_DIR}/docs/api)
  set(DOXYGEN_HTML_OUTPUT .)
  set(DOXYGEN_STRIP_FROM_PATH ${CMAKE_SOURCE_DIR}/src)
  set(DOXYGEN_FILE_PATTERNS *.h)
  set(DOXYGEN_EXTRACT_ALL YES)                 # what has no comment of its own is listed all the same
  set(DOXYGEN_WARN_IF_UNDOCUMENTED NO)
  set(DOXYGEN_WARN_IF_INCOMPLETE_DOC NO)
  set(DOXYGEN_WARN_AS_ERROR FAIL_ON_WARNINGS)
  set(DOXYGEN_MACRO_EXPANSION YES)
  set(DOXYGEN_PREDEFINED "SIMPLEXSEG_HD=" "__restrict__=")
  set(DOXYGEN_MARKDOWN_SUPPORT YES)
  set(DOXYGEN_GENERATE_TREEVIEW YES)
  set(DOXYGEN_SOURCE_BROWSER YES)
  set(DOXYGEN_HAVE_DOT NO)
  set(DOXYGEN_QUIET YES)
  doxygen_add_docs(doc ${CMAKE_SOURCE_DIR}/src COMMENT "Writing docs/api/index.html")
else()
  add_custom_target(doc
    COMMAND ${CMAKE_COMMAND} -E echo "doc: Doxygen is missing; install the package doxygen and configure again"
    COMMAND ${CMAKE_COMMAND} -E false)
endif()
