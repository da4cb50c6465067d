# SPDX-License-Identifier: Apache-2.0
"""Mutation tests of C++ sources: scripts/mutate (docs/adr/0076-evidence-of-tests.md)."""
