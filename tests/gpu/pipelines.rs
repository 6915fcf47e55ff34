//! Pipelines that are made again.

use crate::device::with_device;
use diffract::internals::vk::pipeline::{Code, Constant, Pipeline};

const SHADER: &str = "#version 450
layout(local_size_x = 1) in;
layout(constant_id = 0) const uint number = 0;
shared uint numbers[4];
void main() { numbers[number % 4] = number; }
";

#[test]
fn a_pipeline_that_is_made_again_is_an_idle_one() {
    let compiler = shaderc::Compiler::new().unwrap();
    let kind = shaderc::ShaderKind::Compute;
    let compiled = compiler.compile_into_spirv(SHADER, kind, "number.comp", "main", None).unwrap();
    with_device(|device| {
        let make = |number: u32| {
            let constants = [Constant::new(0, number)];
            let code = Code { name: "number.comp", spirv: compiled.as_binary_u8(), constants: &constants };
            Pipeline::compute(device, code, &[], 0).unwrap()
        };
        let two = [make(1), make(1)];
        let handles = two.each_ref().map(Pipeline::raw);
        assert_ne!(handles[0], handles[1], "two users have one pipeline");
        drop(two);
        assert!(!handles.contains(&make(2).raw()), "a pipeline with other constants");
        assert!(handles.contains(&make(1).raw()));
    });
}
