// SPDX-License-Identifier: MIT
/// @file
/// @brief Everything: from CLI files to tetrahedral meshes in which each element lies in one printed layer.
#pragma once

#include "slice2mesh/cli/read_cli.hpp"
#include "slice2mesh/cli/write_cli.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/slice_stack.hpp"
#include "slice2mesh/fem/activation.hpp"
#include "slice2mesh/fem/boundary_sets.hpp"
#include "slice2mesh/fem/eigen_views.hpp"
#include "slice2mesh/fem/estimates.hpp"
#include "slice2mesh/fem/quadratic.hpp"
#include "slice2mesh/io/write_mesh.hpp"
#include "slice2mesh/pipeline/options.hpp"
#include "slice2mesh/pipeline/slice_to_mesh.hpp"
#include "slice2mesh/plc/verify_plc.hpp"
#include "slice2mesh/quality/format_quality.hpp"
#include "slice2mesh/quality/quality_svg.hpp"
#include "slice2mesh/tet/axioms.hpp"
#include "slice2mesh/tet/external_model.hpp"
#include "slice2mesh/tet/tetrahedralizer.hpp"
#include "slice2mesh/version.hpp"
