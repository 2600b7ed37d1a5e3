use std::process::{Command, Output};

use gi_tests::program::{Folder, assert_success, said};

use crate::running::{path_of, picture, says};

/// Values of the environment variable, and what pictures say of them.
const ALL: [(&str, &str); 4] =
    [("portable", "portable"), ("sse2", "SSE2"), ("avx2", "AVX2"), ("avx512", "AVX-512")];

/// A closed room whose walls emit 1 and reflect half of the light: everybody sees a radiance of 2. A ball of the same
/// material stands in it, so that rays meet triangles and a solid.
const ROOM: &str = r#"<scene version="3.0.0">
<sensor type="perspective"><float name="fov" value="60"/>
<transform name="to_world"><lookat origin="0, 0.3, 1.5" target="0, 0, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/><rfilter type="box"/></film></sensor>
<bsdf type="diffuse" id="half"><rgb name="reflectance" value="0.5"/></bsdf>
<shape type="cube"><transform name="to_world"><scale value="2"/></transform><boolean name="flip_normals" value="true"/>
<emitter type="area"><rgb name="radiance" value="1"/></emitter><ref id="half"/></shape>
<shape type="sphere"><float name="radius" value="0.5"/>
<emitter type="area"><rgb name="radiance" value="1"/></emitter><ref id="half"/></shape>
</scene>"#;

fn render(folder: &Folder, isa: &str, out: &str) -> Output {
    let scene = folder.at("room.xml");
    std::fs::write(&scene, ROOM).expect("written");
    let flags = [scene.as_str(), "-o", &folder.at(out), "--spp", "64", "-q"];
    let mut command = Command::new(path_of("pathtrace"));
    command.args(flags).env("GILAB_ISA", isa).output().expect("it runs")
}

#[test]
fn every_instruction_set_of_this_processor_gives_the_radiance_of_a_closed_room() {
    let (folder, mut greens) = (Folder::make(), Vec::new());
    for (isa, name) in ALL {
        let out = format!("{isa}.exr");
        let output = render(&folder, isa, &out);
        if output.status.code() == Some(2) && said(&output).contains("does not have") {
            eprintln!("skipped: this processor does not have {name}");
            continue;
        }
        assert_success(&output);
        let layers = picture(&folder, &out);
        assert_eq!(says(&layers, "gi.instruction_set"), Some(name));
        let [green, variance] = ["G", "Variance.G"].map(|c| layers.channel(c).expect("a layer"));
        let n = green.len() as f64;
        let mean = green.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
        let error = variance.iter().map(|v| f64::from(*v)).sum::<f64>().sqrt() / n;
        assert!(error < 0.01, "the noise hides errors: {error}");
        // One false alarm in 15,000.
        assert!((mean - 2.0).abs() < 4.0 * error, "{name}: {mean} +- {error}");
        greens.push((name, green.to_vec()));
    }
    assert!(greens.len() >= 2, "{}", greens.len());
}

#[test]
fn an_unknown_instruction_set_is_refused() {
    let folder = Folder::make();
    let output = render(&folder, "mmx", "out.exr");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("GILAB_ISA=mmx is no instruction set"), "{}", said(&output));
}
