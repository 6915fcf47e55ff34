//! What is looked at: meshes with tangent frames, camera, lights, the scene file.
