//! Textures and samplers of a module as parameters of its functions, so that programs that call them declare their own.

use naga::valid::ModuleInfo;
use naga::{
    Block, Expression, Function, FunctionArgument, GlobalVariable, Handle, Literal, Module, Statement,
};
use std::collections::HashMap;

/// Globals that each function uses, itself or through others.
type Uses = HashMap<Handle<Function>, Vec<Handle<GlobalVariable>>>;

/// Returns `module` without globals: every function takes those that it uses as its last parameters, in the order of the module, and passes them on.
/// `name` shortens their names.
pub fn with_parameters(mut module: Module, info: &ModuleInfo, name: fn(&str) -> &str) -> Module {
    let used = |function: Handle<Function>| {
        let handles = module.global_variables.iter().map(|(handle, _)| handle);
        handles.filter(|global| !info[function][*global].is_empty()).collect()
    };
    let uses: Uses = module.functions.iter().map(|(handle, _)| (handle, used(handle))).collect();
    let parameter = |global: &GlobalVariable| FunctionArgument {
        name: global.name.as_deref().map(|long| name(long).to_owned()),
        ty: global.ty,
        binding: None,
    };
    let globals = module.global_variables.take();
    for (handle, function) in module.functions.iter_mut() {
        let mut places = HashMap::new();
        for global in &uses[&handle] {
            let number = function.arguments.len() as u32;
            function.arguments.push(parameter(&globals[*global]));
            let place =
                function.expressions.append(Expression::FunctionArgument(number), naga::Span::UNDEFINED);
            places.insert(*global, (number, place));
        }
        for (_, expression) in function.expressions.iter_mut() {
            if let Expression::GlobalVariable(global) = *expression {
                // The parser names all globals in all functions; nothing refers to those that are not used.
                let number = places.get(&global).map(|(number, _)| *number);
                let nothing = Expression::Literal(Literal::Bool(false));
                *expression = number.map_or(nothing, Expression::FunctionArgument);
            }
        }
        let place_of = |global: &Handle<GlobalVariable>| places[global].1;
        pass_on(&mut function.body, &uses, &place_of);
    }
    module
}

/// Adds to the calls in `block` what the functions that they call use.
fn pass_on(
    block: &mut Block,
    uses: &Uses,
    place_of: &impl Fn(&Handle<GlobalVariable>) -> Handle<Expression>,
) {
    for statement in block.iter_mut() {
        match statement {
            Statement::Call { function, arguments, .. } => {
                arguments.extend(uses[function].iter().map(place_of));
            }
            Statement::Block(inner) => pass_on(inner, uses, place_of),
            Statement::If { accept, reject, .. } => {
                pass_on(accept, uses, place_of);
                pass_on(reject, uses, place_of);
            }
            Statement::Loop { body, continuing, .. } => {
                pass_on(body, uses, place_of);
                pass_on(continuing, uses, place_of);
            }
            Statement::Switch { cases, .. } => {
                cases.iter_mut().for_each(|case| pass_on(&mut case.body, uses, place_of));
            }
            _ => {}
        }
    }
}
