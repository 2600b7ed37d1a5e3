use gi_core::files;
use gi_core::geometry::{Geometry, Mesh, Shape};
use glam::{Affine3A, Mat3, Vec3};

use super::Exporter;
use crate::origins::ShapeOrigin;
use crate::shapes::mesh_file::{MeshFile, MeshKind};
use crate::shapes::ply;

impl Exporter<'_> {
    /// Write all shapes, groups and instances.
    pub(super) fn shapes(&mut self) -> Result<(), String> {
        let loaded = self.loaded;
        for (shape, origin) in loaded.parts.shapes.iter().zip(&loaded.origins.shapes) {
            self.shape(shape, origin)?;
        }
        for (i, (group, origins)) in
            loaded.parts.groups.iter().zip(&loaded.origins.groups).enumerate()
        {
            self.xml.open("shape", &[("type", "shapegroup"), ("id", &format!("group-{i}"))]);
            for (shape, origin) in group.iter().zip(origins) {
                self.shape(shape, origin)?;
            }
            self.xml.close();
        }
        for instance in &loaded.parts.instances {
            self.xml.open("shape", &[("type", "instance")]);
            self.xml.empty("ref", &[("id", &format!("group-{}", instance.group))]);
            self.xml.transform("to_world", &instance.to_world);
            self.xml.close();
        }
        Ok(())
    }

    fn shape(&mut self, shape: &Shape, origin: &ShapeOrigin) -> Result<(), String> {
        match (origin, &shape.geometry) {
            (ShapeOrigin::Unit(kind, to_world), _) => {
                self.xml.open("shape", &[("type", kind)]);
                self.xml.transform("to_world", to_world);
            }
            (ShapeOrigin::File(file, to_world), Geometry::Mesh(mesh)) => {
                self.mesh_file(file, mesh, to_world);
            }
            (_, Geometry::Mesh(mesh)) => self.converted_mesh(mesh)?,
            (_, Geometry::Sphere { center, radius, axes }) => {
                self.xml.open("shape", &[("type", "sphere")]);
                self.xml.value("float", "radius", &radius.to_string());
                let rotation = Mat3::from_cols(axes.s, axes.t, axes.n);
                self.xml.transform("to_world", &Affine3A::from_mat3_translation(rotation, *center));
            }
            (_, Geometry::Disk { center, du, dv }) => {
                self.xml.open("shape", &[("type", "disk")]);
                let n = du.cross(*dv).try_normalize().unwrap_or(Vec3::Z);
                let axes = Mat3::from_cols(*du, *dv, n);
                self.xml.transform("to_world", &Affine3A::from_mat3_translation(axes, *center));
            }
            (_, Geometry::Cylinder { p0, p1, radius }) => {
                self.xml.open("shape", &[("type", "cylinder")]);
                self.xml.value("point", "p0", &super::numbers(&p0.to_array()));
                self.xml.value("point", "p1", &super::numbers(&p1.to_array()));
                self.xml.value("float", "radius", &radius.to_string());
            }
        }
        if shape.flip_normals {
            self.xml.value("boolean", "flip_normals", "true");
        }
        self.material(shape.material)?;
        for (side, medium) in [("interior", shape.interior), ("exterior", shape.exterior)] {
            if let Some(index) = medium {
                let id = self.media[index.index()].clone();
                self.xml.empty("ref", &[("name", side), ("id", &id)]);
            }
        }
        if let Some(emission) = &shape.emission {
            self.xml.open("emitter", &[("type", "area")]);
            self.texture("radiance", emission)?;
            self.xml.close();
        }
        self.xml.close();
        Ok(())
    }

    fn mesh_file(&mut self, file: &MeshFile, mesh: &Mesh, to_world: &Affine3A) {
        let (kind, flip, usual) = match file.kind {
            MeshKind::Obj { flip } => ("obj", flip, true),
            MeshKind::Ply { flip } => ("ply", flip, false),
            MeshKind::Serialized { .. } | MeshKind::Inline => unreachable!("converted"),
        };
        self.xml.open("shape", &[("type", kind)]);
        let name = self.file_name(&file.path);
        self.xml.value("string", "filename", &name);
        if flip != usual {
            self.xml.value("boolean", "flip_tex_coords", &flip.to_string());
        }
        if mesh.normals.is_empty() {
            self.xml.value("boolean", "face_normals", "true");
        }
        self.xml.transform("to_world", to_world);
    }

    fn converted_mesh(&mut self, mesh: &Mesh) -> Result<(), String> {
        let name = self.side_file("ply", |path| {
            files::write(path, &ply::write(mesh)).map_err(|e| e.to_string())
        })?;
        self.xml.open("shape", &[("type", "ply")]);
        self.xml.value("string", "filename", &name);
        if mesh.normals.is_empty() {
            self.xml.value("boolean", "face_normals", "true");
        }
        Ok(())
    }
}
