# SPDX-License-Identifier: Apache-2.0
"""Runs simplexseg-cli over the volumes of a table, and makes one page of what came out (docs/cohort.md)."""
