// Where a ray meets an exact surface near where it meets the mesh: `meet` of intersection.py, in f32.
// needs: surfaces/closed_form.wgsl, surfaces/patch.wgsl
//
// All lengths are in the frame of the mesh: from its origin, in its unit, which is about its size. That the ray begins
// on the mesh, and not at a distant eye, is what makes f32 enough.
//
// Against float64, with 40 random surfaces of each kind, 1 mm to 1 km large: the point is off by at most 1e-7 of the
// mesh's size over the cosine of incidence, the direction of a reflected ray by 1e-7 rad at the median, and at cosines
// from 0.02 to 0.05 by 2e-6 rad on whole spheres and 1e-7 rad on lens faces; at most by 2e-5 and 6e-6. That is what
// rounding the ray to f32 costs. Near the poles of a patch the normal loses what the tangents do.

// The kind is an override constant of the pipeline, so that no other kind's code is left in it. `point` is where the
// ray, of unit direction, meets the mesh; `uv` are the parameters there, which patches need, from 0 to 1 over the
// patch; `facing` is the mesh's normal there, by which the right one of two hits is chosen.
fn meet(kind: u32, first: u32, point: vec3f, direction: vec3f, uv: vec2f, facing: vec3f) -> Met {
    var found = Met(false, 0.0, facing);
    if kind == PATCH {
        found = meet_patch(first, point, direction, uv);
    } else if kind == ROUND {
        found = meet_round(first, point, direction, facing);
    } else if kind != UNKNOWN_SURFACE {
        found = meet_sag(kind, first, point, direction, facing);
    }
    if !found.met {
        return Met(false, 0.0, facing);
    }
    return found;
}
